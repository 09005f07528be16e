"""The blocks of a page, one by one: the HTML that style sheets and scripts rely on."""

from __future__ import annotations

import pytest

from graders.typography import elided
from server.text.markup.tex import tex_as_plain_text
from tests.support.quick import the_course
from tests.support.small_course import CourseFolder
from tests.support.texts_on_disk import FIGURES, GLOSSARY, read_page, without_formulas, write_page

NARROW, WIDE = "\u202f", "\u00a0"


def html(course_folder: CourseFolder, body: str) -> str:
    return without_formulas(read_page(course_folder, body).html)


@pytest.mark.parametrize(
    ("kind", "title", "element"),
    [
        ("definition", "Définition", "section"),
        ("theoreme", "Théorème", "section"),
        ("methode", "Méthode", "section"),
        ("piege", "Piège", "section"),
        ("exercice", "Exercice", "section"),
        ("formule", "Formule", "section"),
        ("exemple", "Exemple", "aside"),
        ("rappel", "Rappel", "aside"),
        ("note", "Note", "aside"),
        ("attention", "Attention", "aside"),
        ("retenir", "À retenir", "aside"),
    ],
)
def test_a_block_has_its_name_and_no_number_without_a_label(
    course_folder: CourseFolder, kind: str, title: str, element: str
) -> None:
    assert html(course_folder, f"::: {kind} L'angle\nTexte.\n:::\n") == (
        f'<{element} class="block block-{kind}"><p class="block-title">'
        f'<span class="block-label">{title}</span> L’angle</p>\n<p>Texte.</p>\n</{element}>\n'
    )


def test_blocks_with_a_label_count_each_kind_for_itself(course_folder: CourseFolder) -> None:
    body = "::: theoreme #thm-{0}\nA\n:::\n\n::: definition #def-{0}\nA\n:::\n"
    page = html(course_folder, body.format("un") + "\n" + body.format("deux"))
    for label, text in (("thm-un", "Théorème"), ("def-un", "Définition")):
        assert f'id="{label}"><p class="block-title"><span class="block-label">{text}{WIDE}1</span>' in page
    for label, text in (("thm-deux", "Théorème"), ("def-deux", "Définition")):
        assert f'id="{label}"><p class="block-title"><span class="block-label">{text}{WIDE}2</span>' in page


def test_a_lesson_of_another_module_is_named_by_its_title(course_folder: CourseFolder) -> None:
    page = html(course_folder, "Voir [](page:l20/filtre-bayesien), ou [là](page:l20/localiser).\n")
    title = the_course().modules["l20"].names().pages["filtre-bayesien"].title
    assert f'<a href="/l20/lire/filtre-bayesien">{title}</a>' in page
    assert '<a href="/l20/lire/localiser">là</a>' in page


def test_a_text_may_begin_with_a_formula_and_end_with_a_digit(course_folder: CourseFolder) -> None:
    assert "$" not in read_page(course_folder, "$x$ qui jette 5\n\n| a |\n|---|\n| $x$ vaut 2 |\n").html


def test_a_title_may_hold_a_formula_and_a_link(course_folder: CourseFolder) -> None:
    page = html(course_folder, "::: methode #met-a Le cas $N = 1$, [](#met-a)\nA\n:::\n")
    assert f'Méthode{WIDE}1</span> Le cas $N = 1$, <a href="#met-a">méthode{WIDE}1</a></p>' in page


def test_an_unnumbered_kind_can_be_linked_to(course_folder: CourseFolder) -> None:
    page = html(course_folder, "::: exemple #ex-simple\nA\n:::\n\nVoir [l'exemple](#ex-simple).\n")
    assert '<aside class="block block-exemple" id="ex-simple">' in page
    assert '<a href="#ex-simple">l’exemple</a>' in page


@pytest.mark.parametrize(
    ("label", "said"),
    [("theoreme", "du {}théorème"), ("definition", "de la {}définition"), ("exercice", "de l’{}exercice")],
)
def test_a_proof_says_what_it_proves_and_ends(course_folder: CourseFolder, label: str, said: str) -> None:
    page = html(course_folder, f"::: {label} #le-un\nA\n:::\n\n::: preuve #le-un\nPar $x$.\n:::\n")
    article, noun = said.split("{}")
    summary = f"<summary>Démonstration {article}{noun}{WIDE}1</summary>"
    back = f'<p class="block-back"><a href="#le-un">{noun}{WIDE}1</a></p>'
    assert f'<details class="block block-preuve" open>{summary}\n{back}\n' in page
    assert '<p>Par $x$.</p>\n<p class="qed">∎</p>\n</details>' in page


def test_a_proof_of_an_equation_and_of_nothing_said(course_folder: CourseFolder) -> None:
    page = html(course_folder, "$$\na\n$$ (eq-a)\n\n::: preuve #eq-a\nA\n:::\n\n::: preuve En bref\nA\n:::\n")
    back = f'<p class="block-back"><a href="#eq-a">équation{WIDE}(1)</a></p>'
    assert f"<summary>Démonstration de l’équation{WIDE}(1)</summary>\n{back}" in page
    assert "<summary>Démonstration — En bref</summary>" in page


def test_a_correction_is_folded_and_needs_no_name_inside_its_exercise(course_folder: CourseFolder) -> None:
    inside = ":::: exercice #ex-a\nA\n\n::: correction #ex-a\nB\n:::\n::::\n"
    page = html(course_folder, f"{inside}\n::: correction #ex-a\nC\n:::\n\n::: correction\nD\n:::\n")
    assert '<details class="block block-correction"><summary>Correction</summary>\n<p>B</p>' in page
    back = f'<p class="block-back"><a href="#ex-a">exercice{WIDE}1</a></p>'
    assert f"<summary>Correction de l’exercice{WIDE}1</summary>\n{back}\n<p>C</p>" in page
    assert "<summary>Correction</summary>\n<p>D</p>" in page


def test_the_empty_corner_of_a_table_is_no_header(course_folder: CourseFolder) -> None:
    page = html(course_folder, "| | un | deux |\n|:-:|:-:|---|\n| a | b | c |\n")
    assert '<td></td>\n<th style="text-align:center">un</th>\n<th>deux</th>' in page


def test_anything_can_be_folded(course_folder: CourseFolder) -> None:
    page = html(course_folder, "::: repli Pour aller plus loin\nA\n:::\n")
    assert page == (
        '<details class="block block-repli"><summary>Pour aller plus loin</summary>\n<p>A</p>\n</details>\n'
    )


def test_a_figure_has_its_number_both_themes_and_its_text(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/m9/figures/dessins.py", FIGURES)
    first = "::: figure bande\nUne **bande**.\n\nSuite.\n:::\n"
    page = html(course_folder, f"{first}\n::: figure trace\nB\n:::\n\nVoir [](#fig-trace).")
    size = 'alt="Une bande." loading="lazy" width="640" height="200">'
    assert (
        '<figure class="drawing" id="fig-bande">'
        f'<img class="figure-light" src="/m9/figures/bande.svg?theme=light" {size}'
        f'<img class="figure-dark" src="/m9/figures/bande.svg?theme=dark" {size}'
        f'<figcaption><span class="figure-number">Figure{WIDE}1{WIDE}:</span> Une <strong>bande</strong>.'
    ) in page
    assert 'alt="Une ligne qui monte &amp; l’axe." loading="lazy" width="640" height="400"' in page
    assert f'<a href="#fig-trace">figure{WIDE}2</a>' in page


def test_a_replay_stands_with_its_words(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/m9/rejeux/a_etoile.py", "")
    assert html(course_folder, "::: rejeu a-etoile\nRegardez.\n:::\n") == (
        '<figure class="replay" id="rejeu-a-etoile" data-source="/m9/rejeux/a-etoile">'
        '<div class="replay-stage"></div><figcaption><p>Regardez.</p>\n</figcaption></figure>\n'
    )


def test_a_manipulation_stands_with_its_words_and_a_drawing_for_who_has_no_script(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/m9/manipulations/bande/scene.py", "")
    course_folder.write("curriculum/m9/figures/dessins.py", FIGURES.replace('"bande"', '"manipulation-bande"'))
    page = html(course_folder, "::: manipulation bande\nTirez.\n:::\n")
    assert page.startswith(
        '<figure class="replay manipulation" id="manipulation-bande" data-hands="/m9/manipulations/bande">'
        '<div class="without-script"><img class="figure-light" src="/m9/figures/manipulation-bande.svg?theme=light" '
        'alt="Une bande."'
    )
    assert page.endswith('</div><div class="replay-stage"></div><figcaption><p>Tirez.</p>\n</figcaption></figure>\n')


def test_a_cell_and_shown_code(course_folder: CourseFolder) -> None:
    page = read_page(course_folder, "```python cellule deux-rayons\nprint('<b>')\n```\n\n```bash\nls\n```\n\n    nu\n")
    assert (
        '<section class="cell" id="cellule-deux-rayons" data-name="deux-rayons" data-action="/m9/cellules">'
        '<div class="cell-code"><pre class="code"'
    ) in page.html
    assert "&lt;b&gt;" in page.html
    assert page.html.count('<div class="code-block"><pre class="code" tabindex="0">') == 2
    assert [(one.name, one.code) for one in page.cells] == [("deux-rayons", "print('<b>')\n")]


def test_equations_are_numbered_when_they_have_a_label(course_folder: CourseFolder) -> None:
    page = html(course_folder, "On a\n$$\na\n$$ (eq-a)\npuis $$b$$ et\n\n$$c$$\n\n$$\nd\n$$ (eq-d)\n\nPar [](#eq-d).\n")
    assert page.startswith("<p>On a</p>\n")
    number = '<span class="equation-number">(1)</span>'
    assert f'<div class="math-display equation" id="eq-a" tabindex="0">$a${number}</div>' in page
    assert '<div class="math-display" tabindex="0">$c$</div>' in page
    assert "puis $b$ et" in page
    assert '<span class="equation-number">(2)</span>' in page
    assert '<a href="#eq-d">(2)</a>' in page


def test_links(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/m9/glossaire.toml", GLOSSARY)
    write_page(course_folder, "deux", "## Un titre\n\n::: piege #piege-a\nA\n:::\n", folder="annexes")
    page = html(
        course_folder,
        "::: theoreme #thm-un\nA\n:::\n\n[](page:deux) [x](page:deux#s-un-titre) [](#piege-a) [ici](#piege-a) "
        "[](exo:a) [une pose](terme:pose) [](terme:pose) [](page:glossaire) [x](page:glossaire#t-pose) "
        "[là](https://exemple.fr/?a=1&b=2)\n",
    )
    for link in (
        '<a href="/m9/lire/deux">Titre de deux</a>',
        '<a href="/m9/lire/deux#s-un-titre">x</a>',
        f'<a href="/m9/lire/deux#piege-a">piège{WIDE}1</a>',
        '<a href="/m9/lire/deux#piege-a">ici</a>',
        '<a href="/m9/exercices/a">Doubler</a>',
        '<a class="term" data-term="pose" href="/m9/glossaire#t-pose">une pose</a>',
        '<a class="term" data-term="pose" href="/m9/glossaire#t-pose">pose</a>',
        '<a href="/m9/glossaire">glossaire</a>',
        '<a href="/m9/glossaire#t-pose">x</a>',
        '<a class="external" rel="noopener noreferrer" href="https://exemple.fr/?a=1&amp;b=2">là</a>',
    ):
        assert link in page


def test_headings_are_known_with_their_formulas_and_without_links(course_folder: CourseFolder) -> None:
    page = read_page(
        course_folder, "## L'angle $\\theta$, [](#def-a) `x`\n\n### Détail\n\n::: definition #def-a\nA\n:::\n"
    )
    first, second = page.headings
    assert (first.level, first.id, first.text) == (2, "s-l-angle-x", f"L’angle θ, définition{WIDE}1 x")
    assert without_formulas(first.html) == "L’angle $\\theta$,  <code>x</code>"
    assert (second.level, second.id, second.html) == (3, "s-detail", "Détail")
    assert f'<a href="#def-a">définition{WIDE}1</a>' in page.html


def test_notes_lists_tables_and_definitions(course_folder: CourseFolder) -> None:
    page = html(
        course_folder, "Un mot[^a], encore[^a].\n\n[^a]: La note.\n\nmot\n: son sens\n\n| a |\n|---|\n| $x$ |\n"
    )
    assert '<sup class="footnote-ref"><a href="#fn1" id="fnref1">[1]</a></sup>' in page
    assert '<a href="#fnref1:1" class="footnote-backref" aria-label="Retour au texte">' in page
    assert "<dt>mot</dt>" in page
    assert '<div class="table-scroll" tabindex="0"><table>' in page


def test_blocks_stand_in_lists_and_in_each_other(course_folder: CourseFolder) -> None:
    listed = "- un\n\n  ::: note\n  Dedans.\n  :::\n\n"
    page = html(course_folder, f"{listed}::::: repli A\n:::: note\n::: exemple\nB\n:::\n::::\n:::::\n")
    assert page.index("<li>") < page.index("Dedans") < page.index("</li>")
    nested = [page.rindex(one) for one in ("block-repli", "block-note", "block-exemple", "</details>")]
    assert nested == sorted(nested)


@pytest.mark.parametrize(
    ("word", "name", "said"),
    [
        ("de", "odometrie", "d’odometrie"),
        ("que", "a_la_date", "qu’a_la_date"),
        ("de", "élargir", "d’élargir"),
        ("de", "gain", "de gain"),
        ("de", "a", "de a"),
    ],
)
def test_a_name_is_elided_as_a_word_is(word: str, name: str, said: str) -> None:
    assert elided(word, name) == said


def test_typography(course_folder: CourseFolder) -> None:
    page = html(course_folder, '"Quoi ?" dit-il... un -- deux ; `a ? b`, (c) \\$ et \\*\n')
    assert page == f"<p>«{WIDE}Quoi{NARROW}?{WIDE}» dit-il… un – deux{NARROW}; <code>a ? b</code>, (c) $ et *</p>\n"


@pytest.mark.parametrize(
    ("tex", "text"),
    [
        ("\\theta \\in \\mathopen]-\\pi, \\pi\\mathclose]", "θ ∈ ]-π, π]"),
        ("\\frac{a_{1}}{\\sqrt{2}}", "a_1/√2"),
        ("\\ln \\frac{p}{1-p} = 0{,}5", "ln p/1-p = 0,5"),
        ("\\cos(\\theta)", "cos(θ)"),
        ("\\begin{pmatrix} a & b \\\\ c & d \\end{pmatrix}", "a b c d"),
        ("\\lVert e \\rVert_\\Omega", "‖ e ‖_Ω"),
        ("\\lambda \\oplus \\Lambda", "λ ⊕ Λ"),
        ("\\frac{\\frac{a}{b}}{c}", "a/b/c"),
        ("", ""),
        ("\\frac{a", "a"),
    ],
)
def test_tex_as_a_line_of_text(tex: str, text: str) -> None:
    assert tex_as_plain_text(tex) == text


def test_sections_are_plain_text_in_which_links_and_numbers_are_said(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/m9/figures/dessins.py", FIGURES)
    page = read_page(
        course_folder,
        "Avant [](#eq-a).\n\n## Un *titre*\n\n::: theoreme #thm-a Nom\nSoit $\\theta$.\n:::\n\n$$\nx = 1\n$$ (eq-a)\n\n"
        "## Deux\n\n```python\nprint(1)\n```\n\n::: figure trace\nLégende.\n:::\n",
    )
    assert [(one.id, one.title, one.text) for one in page.sections] == [
        ("", "", "Avant (1)."),
        ("s-un-titre", "Un titre", f"Théorème{WIDE}1 : Nom Soit θ. x = 1"),
        ("s-deux", "Deux", "print(1) Légende."),
    ]
    assert page.figures == ("trace",)
