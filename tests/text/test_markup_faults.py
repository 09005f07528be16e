"""Everything that a writer can get wrong is told with its line; nothing that is written can run."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from server.text.markup import MarkdownSource, MarkdownText, ModuleNames, PictureSize
from server.web import assets
from tests.support.quick import one_in
from tests.support.small_course import CourseFolder
from tests.support.texts_on_disk import FIGURES, GLOSSARY, faults, page, problems, write_page

needs_katex = pytest.mark.skipif(not assets.is_frontend_built(), reason="the front end is not built here")

BAD = {
    "unknown block": ("A\n\n::: sottise\nB\n:::\n", 3, "encadré inconnu : « sottise »"),
    "block left open": ("::: note\nA\n", 1, "encadré non refermé"),
    "outer block with too few colons": ("::: note\n::: exemple\nA\n:::\n:::\n", 2, "encadré non refermé"),
    "closed twice": ("::: note\nA\n:::\n\nB\n\n:::\n", 7, "sans encadré ouvert"),
    "malformed label": ("::: note #Été\nA\n:::\n", 1, "étiquette mal formée"),
    "reserved label": ("::: note #s-titre\nA\n:::\n", 1, "étiquette réservée"),
    "label given twice": ("::: note #a\nA\n:::\n\n::: note #a\nB\n:::\n", 5, "« #a » figure deux fois"),
    "malformed equation label": ("$$\na\n$$ (Eq A)\n", 1, "étiquette mal formée"),
    "fold without a title": ("::: repli\nA\n:::\n", 1, "un repli a un titre"),
    "proof of nothing": ("A\n\n::: preuve #inconnu\nA\n:::\n", 3, "étiquette inconnue : « #inconnu »"),
    "unknown figure": ("A\n\n::: figure absente\nA\n:::\n", 3, "figure inconnue : « absente »"),
    "figure with a title": ("::: figure trace Un titre\nA\n:::\n", 1, "il faut un nom et rien d’autre"),
    "figure without a caption": ("A\n\n::: figure trace\n:::\n", 3, "il manque le texte"),
    "figure shown twice": (
        "::: figure trace\nA\n:::\n\n::: figure trace\nA\n:::\n",
        5,
        "« #fig-trace » figure deux fois",
    ),
    "unknown question": ("::: question absent/q\n:::\n", 1, "question inconnue : « absent/q »"),
    "question with a text": ("::: question absent/q\nA\n:::\n", 1, "rien ne se met dans « question »"),
    "exercise to do with a text": ("::: faire absent\nA\n:::\n", 1, "rien ne se met dans « faire »"),
    "unknown exercise to do": ("::: faire absent\n:::\n", 1, "exercice inconnu : « absent »"),
    "unknown retrieval question": ("::: redire absente\n:::\n", 1, "question à redire inconnue : « une/absente »"),
    "part for later without a title": ("::: plus-tard lycee\nA\n:::\n", 1, "il faut un chemin du module et un titre"),
    "unknown path": ("A\n\n::: plus-tard absent B\nA\n:::\n", 3, "chemin inconnu : « absent »"),
    "malformed question": ("::: question absent\n:::\n", 1, "il faut un nom et rien d’autre"),
    "unknown replay": ("::: rejeu absent\nA\n:::\n", 1, "rejeu inconnu : « absent »"),
    "unknown manipulation": ("::: manipulation absente\nA\n:::\n", 1, "manipulation inconnue : « absente »"),
    "unknown label": ("A\nB [x](#absent)\n", 2, "étiquette inconnue : « #absent »"),
    "link that nobody can name": ("::: note #a\nA\n:::\n\nB [](#a)\n", 5, "n’a pas de numéro"),
    "unknown page": ("A\n\n- b\n- [x](page:absente)\n", 4, "page inconnue : « absente »"),
    "unknown place in a page": ("[x](page:une#absent)\n", 1, "la page « une » n’a pas de « #absent »"),
    "unknown exercise": ("[x](exo:absent)\n", 1, "exercice inconnu : « absent »"),
    "unknown term": ("[x](terme:absent)\n", 1, "terme inconnu du glossaire : « absent »"),
    "unknown term of the glossary's page": ("[x](page:glossaire#t-absent)\n", 1, "terme inconnu du glossaire"),
    "link to elsewhere": ("[x](/l20)\n", 1, "lien inconnu : « /l20 »"),
    "link without encryption": ("A\n\nB\n[x](http://exemple.fr)\n", 4, "lien inconnu"),
    "link in a table": ("| a |\n|---|\n| [x](#absent) |\n", 3, "étiquette inconnue"),
    "link in a title": ("::: note Voir [x](#absent)\nA\n:::\n", 1, "étiquette inconnue"),
    "link with a space": ("A\n\n[x](page: une)\n", 3, "lien mal écrit"),
    "image": ("A\n\n![x](https://exemple.fr/x.png)\n", 3, "les images ne sont pas servies"),
    "HTML": ("A\n\nB<br>C\n", 3, "pas de HTML"),
    "HTML comment": ("A\n\n<!-- B -->\n", 3, "pas de HTML"),
    "heading of level 1": ("A\n\n# Titre\n", 3, "titre de niveau 1"),
    "heading too deep": ("## A\n\n### B\n\n#### C\n\n##### D\n", 7, "titre trop profond"),
    "heading that skips a level": ("## A\n\n#### B\n", 3, "titre de niveau 4 juste sous un titre de niveau 2"),
    "unknown page of another module": ("[x](page:l99/absente)\n", 1, "page inconnue : « l99/absente »"),
    "formula left open": ("A\n\nLe $x vaut 1.\n", 3, "formule mal fermée"),
    "formula against a digit": ("2$x$ et la suite\n", 1, "formule mal fermée"),
    "bold left open": ("A\n**b\n", 2, "gras ou code mal refermé"),
    "note without a text": ("A[^a].\n", 1, "note de bas de page sans texte"),
    "note never called": ("A\n\n[^a]: B\n", 3, "note de bas de page jamais appelée : « a »"),
    "unknown language": ("```pithon\nx\n```\n", 1, "langage inconnu : « pithon »"),
    "words after the language": ("```python sauvage\nx\n```\n", 1, "après le langage, rien"),
    "cell without a name": ("```python cellule\nx\n```\n", 1, "après le langage, rien"),
    "cell in another language": ("```bash cellule a\nx\n```\n", 1, "après le langage, rien"),
    "cell with a bad name": ("```python cellule Été\nx\n```\n", 1, "nom de cellule mal formé"),
    "two cells of one name": (
        "```python cellule a\nx\n```\n\n```python cellule a\nx\n```\n",
        5,
        "« #cellule-a » figure deux fois",
    ),
    "cell that does not compile": ("A\n\n```python cellule a\nx = 1\ny = (\n```\n", 5, "ne se compile pas"),
}


@pytest.mark.parametrize(("body", "line", "message"), BAD.values(), ids=BAD.keys())
def test_a_fault_is_told_with_its_line(course_folder: CourseFolder, body: str, line: int, message: str) -> None:
    course_folder.write("curriculum/m9/figures/dessins.py", FIGURES)
    found = faults(course_folder, body)
    assert any(where == line and message in said for where, said in found), found
    assert len({where for where, _ in found}) <= 2, "one mistake is not told all over the page"


@pytest.mark.parametrize(("body", "line", "message"), one_in(4, BAD.values()), ids=BAD.keys())
def test_a_page_at_fault_is_told_without_drawing_formulas_and_still_reads(
    course_folder: CourseFolder, body: str, line: int, message: str
) -> None:
    write_page(course_folder, "une", body + "\n\nLa fin.\n")
    assert problems(course_folder, render=False) == []
    assert any(message in one.message for one in problems(course_folder, render=False, check=True))
    assert "La fin." in page(course_folder, "une").html


@needs_katex
@pytest.mark.parametrize(
    ("body", "line"),
    [
        ("A\n\nB $\\frac{1}{$ C\n", 3),
        ("A\n\n$$\nx = 1 \\\\\ny = \\inconnu\n$$ (eq-a)\n", 5),
        ("A\nB $$\n\\inconnu\n$$\n", 3),
        ("## A $\\inconnu$\n", 1),
        ("::: note $\\inconnu$\nA\n:::\n", 1),
        ("| a |\n|---|\n| $\\inconnu$ |\n", 3),
        ("- a\n- b\n\n  $\\inconnu$\n", 4),
        ("A[^a]\n\n[^a]: B\n    $\\inconnu$\n", 4),
    ],
)
def test_bad_tex_is_told_with_its_line_and_stands_as_it_is(course_folder: CourseFolder, body: str, line: int) -> None:
    ((where, message),) = faults(course_folder, body)
    assert (where, message[:15]) == (line, "formule refusée")
    assert problems(course_folder, render=False, check=True) == []
    assert '<code class="fault">' in page(course_folder, "une").html


def test_a_statement_has_no_label_and_none_of_what_a_page_brings_to_life(course_folder: CourseFolder) -> None:
    for body in (
        "::: theoreme #a\nA\n:::\n",
        "$$\na\n$$ (eq-a)\n",
        "::: figure trace\nA\n:::\n",
        "```python cellule a\nx\n```\n",
    ):
        path = course_folder.write("curriculum/m9/exercices/a/enonce.md", f"A\n\n{body}")
        found = problems(course_folder)
        assert {(one.path, one.line) for one in found} == {(path, 3)}
        assert any("n’a sa place que dans une page à lire" in one.message for one in found)


def test_statements_and_hints_may_speak_of_pages(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/m9/glossaire.toml", GLOSSARY)
    write_page(course_folder, "une", "::: theoreme #thm-un\nA\n:::\n")
    path = course_folder.exercise("a") / "enonce.md"
    path.write_text("[](#thm-un) [](page:une) [x](terme:pose) [](exo:b)\n", encoding="utf-8")
    assert problems(course_folder) == []
    html = course_folder.load(render=False).exercises["m9/a"].statement_html
    for href in ("/m9/lire/une#thm-un", "/m9/lire/une", "/m9/glossaire#t-pose", "/m9/exercices/b"):
        assert f'href="{href}"' in html
    path.write_text("A\n\n[](#thm-deux)\n", encoding="utf-8")
    (problem,) = problems(course_folder)
    assert (problem.path, problem.line) == (path, 3)


PIECES = [
    "::: note\n", ":::\n", "::: figure trace\n", ":::: exercice #x T\n", "::::\n", "::: preuve #x\n", "::: repli T\n",
    "```python cellule a\n", "```\n", "## T $x$\n", "$$\n", "$$ (eq-a)\n", "$x$ ", "[](#x)", "[a](page:une)", "[^a]",
    "[^a]: t\n", "    ", "- ", "> ", "| a |\n|---|\n| b |\n", "mot\n: d\n", "**", "`", "\n", "texte ", "\\",
    "::: rejeu r\n", "<b>", "<script>", "1. ", "$$a$$", "\t", "\r\n", "\0", "é", '"onclick=x ',
]  # fmt: skip

WORDS = st.text(st.characters(exclude_categories=["Cs", "Co"]), max_size=4)  # the engine marks places with some of "Co"


@settings(deadline=None, max_examples=150)
@given(st.lists(st.sampled_from(PIECES) | WORDS, max_size=25).map("".join), st.sampled_from(["", "une"]))
def test_any_text_is_read_to_the_end_and_closes_what_it_opens(written: str, slug: str) -> None:
    names = ModuleNames(module="m9", pictures={"trace": PictureSize("Une ligne.", 640, 400)}, replays={"r"})
    text = MarkdownText(MarkdownSource(written, Path("une.md"), page=slug, names=lambda: names))
    assert text.find_faults(formulas=True) == tuple(sorted(text.find_faults(formulas=True), key=lambda one: one.line))
    assert not Whole(text.html).seen & {"script", "b"}
    for heading in text.headings:
        Whole(heading.html)
    assert not any(mark in section.text for section in text.sections for mark in "\ue000\ue001\ue002")
    Whole(MarkdownText(MarkdownSource(written, Path("une.md"), names=lambda: names), inline=True).html)


class Whole(HTMLParser):
    """A piece of HTML whose elements close as they open."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.seen: set[str] = set()
        self._open: list[str] = []
        self.feed(html)
        self.close()
        assert self._open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag not in {"br", "hr", "img"}:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag


class Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.seen: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append((tag, dict(attrs)))


@pytest.mark.parametrize(
    "attack",
    [
        '::: theoreme #a"><script>alert(1)</script>\nx\n:::',
        "::: note <img src=x onerror=alert(1)>\nx\n:::",
        "::: repli <script>alert(1)</script>\nx\n:::",
        '::: preuve #"onload=alert(1)\nx\n:::',
        '::: figure x"onerror="alert(1)\nx\n:::',
        '::: rejeu x"onclick="alert(1)\nx\n:::',
        '::: "onclick="alert(1)\nx\n:::',
        '```python cellule a"onclick="alert(1)\nx\n```',
        '```"onclick="alert(1)\nx\n```',
        "```python cellule a\n</code></pre><script>alert(1)</script>\n```",
        '[](#"onclick="alert(1))',
        '[](page:"onclick="alert(1))',
        '[x](terme:"><script>alert(1)</script>)',
        '[x](https://exemple.fr/"onclick="alert(1))',
        "[x](javascript:alert(1))",
        "[x](data:text/html,<script>alert(1)</script>)",
        "[x]: javascript:alert(1)\n\n[x]",
        '[x](https://exemple.fr "t\\" onclick=alert(1)")',
        '$$\na\n$$ (x"onclick="alert(1))',
        "$\\href{javascript:alert(1)}{x}$ $\\htmlData{onclick=x}{y}$ $\\includegraphics{x}$",
        "## A {onclick=alert(1)} <script>",
        "[^<script>alert(1)</script>]\n\n[^<script>alert(1)</script>]: x",
        "| <script>alert(1)</script> |\n|---|\n| <img src=x onerror=alert(1)> |",
    ],
)
def test_nothing_in_a_page_can_run(course_folder: CourseFolder, attack: str) -> None:
    write_page(course_folder, "une", attack)
    tags = Tags()
    tags.feed(page(course_folder, "une").html)
    assert not {tag for tag, _ in tags.seen} & {"script", "iframe", "object", "embed", "form"}
    for _, attributes in tags.seen:
        assert not [name for name in attributes if name.startswith("on")]
        for name in ("href", "src"):
            assert not str(attributes.get(name) or "").lower().startswith(("javascript:", "data:"))


def test_a_text_needs_no_page_around_it(course_folder: CourseFolder) -> None:
    """What an author of another kind of question may write: one paragraph, no place of its own."""
    text = MarkdownText(MarkdownSource("Le *mot* [x](page:une)", course_folder.root), inline=True)
    assert text.html == 'Le <em>mot</em> <a class="fault">x</a>'
    assert [one.message for one in text.find_faults(formulas=True)] == ["page inconnue : « une »"]
