"""The statements' Markdown: French typography, mathematics, boxes, and nothing that could run."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graders import typography
from graders.typography import french
from server.text import katex
from server.text.markup import MarkdownSource, MarkdownText
from server.web import assets

needs_katex = pytest.mark.skipif(not assets.is_frontend_built(), reason="the front end is not built here")


def html(text: str) -> str:
    return MarkdownText(MarkdownSource(text, Path("enonce.md"))).html


def test_a_long_text_is_written_as_a_short_one_and_not_kept() -> None:
    before = typography._cached_french.cache_info().currsize
    assert french("Vu " * 200 + "?") == "Vu " * 199 + "Vu\u202f?"
    assert typography._cached_french.cache_info().currsize == before


def test_french_typography() -> None:
    assert html('Vraiment ? Oui : "mot" ; l\'angle !') == (
        "<p>Vraiment\u202f? Oui\u00a0: «\u00a0mot\u00a0»\u202f; l’angle\u202f!</p>\n"
    )


def test_typography_spares_code_and_mathematics() -> None:
    assert "d['a'] ; x ? y" in html("`d['a'] ; x ? y`")
    assert "d[&#x27;a&#x27;] ; x" in html("```\nd['a'] ; x\n```")


@needs_katex
@pytest.mark.parametrize(
    ("text", "before", "after"),
    [
        ("soit $x$, puis", "", ","),
        ("soit ($x$) puis", "(", ")"),
        ("soit $x$ ; puis", "", "\u202f;"),
        ("soit « $x$ » ici", "«\u00a0", "\u00a0»"),
        ("l'$x$ des", "’", ""),
        ("soit $x$ m, puis", "", " m,"),
        ("soit $x$ rad/s puis", "", " rad/s"),
        ("soit $x$ % puis", "", " %"),
    ],
)
def test_a_formula_keeps_the_punctuation_that_touches_it(text: str, before: str, after: str) -> None:
    page = html(text)
    assert f'<span class="held">{before}<span class="katex">' in page
    assert f"</span>{after}</span> " in page
    bare = html(text.replace("$x$", "x"))
    assert bare.replace("x", "") == re.sub(r'<span class="katex">.*</span></span></span>|</?span[^>]*>', "", page)


@needs_katex
def test_a_formula_alone_is_left_alone() -> None:
    assert "held" not in html("soit $x$ et $y$ mesurés, $u$ m'attire, puis **$z$**")


@settings(deadline=None)
@given(st.text())
def test_typography_changes_only_spaces_and_apostrophes(text: str) -> None:
    def bare(one: str) -> str:
        return "".join(" " if char in "\u00a0\u202f" else char for char in one).replace("’", "'")

    assert bare(french(text)) == bare(text)
    assert french(french(text)) == french(text)


@pytest.mark.parametrize(
    "attack",
    [
        "<script>alert(1)</script>",
        "<img src=x onerror=alert(1)>",
        "[x](javascript:alert(1))",
        "```python\n</code></pre><script>alert(1)</script>\n```",
        "$\\text{<script>alert(1)</script>}$",
        "$\\href{javascript:alert(1)}{x}$",
        "::: note <script>alert(1)</script>\nx\n:::",
        "## <script>alert(1)</script>",
    ],
)
def test_nothing_in_a_statement_can_run(attack: str) -> None:
    from html.parser import HTMLParser

    seen: list[tuple[str, dict[str, str | None]]] = []

    class Tags(HTMLParser):
        def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
            seen.append((tag, dict(attrs)))

    Tags().feed(html(attack))
    assert not {tag for tag, _ in seen} & {"script", "img", "iframe", "object"}
    for _, attributes in seen:
        assert not [name for name in attributes if name.startswith("on")]
        assert not str(attributes.get("href", "")).startswith("javascript:")


def test_headings_can_be_linked_to() -> None:
    assert '<h2 id="s-ce-qu-est-une-pose">' in html("## Ce qu’est une pose")
    assert '<h2 id="s-des-noeuds">' in html("## Des nœuds")


def test_boxes_and_tables() -> None:
    page = html("::: attention Angles\nEn radians.\n:::\n\n| a |\n|---|\n| 1 |\n")
    assert '<p class="block-title"><span class="block-label">Attention</span> Angles</p>' in page
    assert '<div class="table-scroll"' in page


@needs_katex
@pytest.mark.parametrize(
    "tex",
    [
        "\\theta",
        "\\frac{1}{2}",
        "\\arg\\max_x p(x)",
        "a \\oplus b",
        "\\begin{pmatrix}1&2\\\\3&4\\end{pmatrix}",
        "\\bigg(",
    ],
)
def test_mathematics_is_drawn_and_readable_aloud(tex: str) -> None:
    page = html(f"${tex}$")
    assert 'class="katex"' in page
    assert "<math" in page


@needs_katex
def test_display_mathematics_of_several_lines() -> None:
    page = html("$$\n\\begin{aligned}\nx &= 1 \\\\\ny &= 2\n\\end{aligned}\n$$")
    assert "katex-display" in page


@needs_katex
def test_bad_tex_says_where() -> None:
    text = MarkdownText(MarkdownSource("Un.\n\nDeux $x$ et\ntrois $\\frac{1}{$ là.\n", Path("enonce.md")))
    (fault,) = text.find_faults(formulas=True)
    assert fault.line == 4
    assert "formule refusée" in fault.message
    assert "<code" in text.html, "the rest of the text can still be read"


@needs_katex
def test_formulas_may_be_drawn_from_many_threads() -> None:
    katex.drawn.clear()
    formulas = [f"x_{{{number}}}" for number in range(60)]
    with ThreadPoolExecutor(8) as pool:
        drawn = list(pool.map(lambda tex: katex.render_formula(tex, display=False), formulas))
    assert drawn == [katex.render_formula(tex, display=False) for tex in formulas]
    assert all(f">{number}<" in one for number, one in enumerate(drawn))


def test_without_katex_formulas_stay_readable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(katex, "shared_katex_engine", lambda: None)
    katex.drawn.clear()
    assert "<code>a &lt; \\theta</code>" in html("$a < \\theta$")
    katex.drawn.clear()
