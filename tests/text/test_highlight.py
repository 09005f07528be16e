"""Code drawn: what has a colour has an element, and nothing else."""

from __future__ import annotations

import html
import re
from pathlib import Path

from server.text import highlight

BASE = Path(highlight.__file__).parents[1] / "frontend/src/css/base.css"
CODE = 'def f(a: int) -> str:\n    """Dit."""\n    return f"{a + 1} < {2.5e3}" if not a else None  # fin\n'


def test_the_classes_are_those_that_the_style_sheet_colours() -> None:
    assert set(re.findall(r"^\.code \.(\w+)", BASE.read_text(encoding="utf-8"), re.MULTILINE)) == highlight.COLOURED


def test_only_what_has_a_colour_has_an_element_and_the_text_stays() -> None:
    drawn = highlight.highlight_code_block(CODE)
    assert set(re.findall(r'<span class="([^"]*)"', drawn)) == {
        "k",
        "nf",
        "sd",
        "sa",
        "s2",
        "si",
        "mi",
        "mf",
        "ow",
        "kc",
        "c1",
    }
    assert html.unescape(re.sub("<[^>]*>", "", drawn)) == CODE + "\n"
    assert (
        highlight.highlight_code_block("x = a.b(c)[d]\n")
        == '<pre class="code" tabindex="0"><code>x = a.b(c)[d]\n</code></pre>\n'
    )


def test_an_unknown_language_is_plain() -> None:
    assert "<span" not in highlight.highlight_code_block("def f(): pass", "brainfog")
