"""The Python of students in colours: the text stays, each line stands alone, and time is linear, whatever the text."""

from __future__ import annotations

import html
import re
import time
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.text import highlight, python_colours
from server.text.python_colours import (
    MOST_TOKENS,
    colour_python_block,
    colour_python_lines,
    colour_python_lines_uncached,
)

CODE = '''@np.vectorize
def f(a: int) -> str:
    """Dit,
    en deux lignes."""
    return rb"\\" # <" if not a else 0x1F + 2.5e3 - 1_000j  # fin
class A: x = None
'''
FRAGMENTS = (
    "'",
    '"',
    "'''",
    '"""',
    "\\",
    "\n",
    "#",
    "f",
    "rb",
    "{",
    "}",
    "(",
    "@a",
    " ",
    "1.",
    "1e",
    "0x",
    "é",
    "\r",
    "match",
)
#: Texts that made another colourer, or may make one, read the rest again from each character.
SHAPES = {
    "blanks after a word": lambda n: "match" + " " * n + "x",
    "zeros after a percent": lambda n: "'%" + "0" * n,
    "brackets": lambda n: "(" * n,
    "quotes": lambda n: "'" * n,
    "an open long string": lambda n: "'''" + "a'" * (n // 2),
    "backslashes in a string": lambda n: '"' + "\\" * n,
    "prefixes": lambda n: "rb'" * (n // 3),
    "digits": lambda n: "1_" * (n // 2),
    "exponents": lambda n: "1e" * (n // 2),
    "points": lambda n: "1.1." * (n // 4),
    "decorators": lambda n: "@a." * (n // 3),
    "lines": lambda n: "\n" * n,
    "formats": lambda n: "f'{" * (n // 3),
}


def text_of(lines: list[str]) -> str:
    return html.unescape(re.sub("<[^>]*>", "", "\n".join(lines)))


def test_what_has_a_colour_has_its_class() -> None:
    drawn = colour_python_block(CODE)
    pairs = re.findall(r'<span class="(\w+)">([^<]*)</span>', drawn)
    assert {style for style, _ in pairs} <= highlight.COLOURED
    found = {html.unescape(text): style for style, text in pairs}
    for text, style in {
        "@np.vectorize": "nd", "def": "k", "f": "nf", '"""Dit,': "sd", 'en deux lignes."""': "sd", "rb": "sa",
        '"\\" # <"': "s2", "not": "ow", "0x1F": "mh", "2.5e3": "mf", "1_000j": "mf", "# fin": "c1", "A": "nc",
        "None": "kc",
    }.items():  # fmt: skip
        assert {key.strip(): value for key, value in found.items()}[text] == style


@given(st.lists(st.sampled_from(FRAGMENTS)).map("".join) | st.text())
def test_the_text_stays_and_each_line_stands_alone(code: str) -> None:
    lines = colour_python_lines(code)
    assert text_of(lines) == code.removesuffix("\n")
    assert len(lines) == code.removesuffix("\n").count("\n") + 1
    assert all(line.count("<span") == line.count("</span>") for line in lines)


@pytest.mark.parametrize("shape", SHAPES)
def test_no_text_takes_more_than_linear_time(shape: str) -> None:
    """Processor time of four times the text against that of one, the best of three: 4 if linear, 16 if quadratic."""

    def seconds(size: int) -> float:
        code, best = SHAPES[shape](size), float("inf")
        for _ in range(3):
            began = time.process_time()
            colour_python_lines_uncached(code)
            best = min(best, time.process_time() - began)
        return best

    assert seconds(64_000) <= 8 * max(seconds(16_000), 0.002)


@pytest.mark.parametrize("text", ["x\n" * 30_000, "#\n" * 30_000, '"a"+' * 15_000, "(" * 60_000])
def test_a_long_file_is_coloured_for_a_bounded_number_of_tokens(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """50 ms of everybody's processor for each view of a page, of any guest's file of 64 KB."""
    asked, split = 0, python_colours.split_into_coloured_tokens

    def count(code: str) -> Iterator[tuple[str, str]]:
        nonlocal asked
        for token in split(code):
            asked += 1
            yield token

    monkeypatch.setattr(python_colours, "split_into_coloured_tokens", count)
    text += f"# {asked} {id(monkeypatch)}"
    assert text_of(colour_python_lines(text)) == text
    assert 0 < asked <= MOST_TOKENS
    first, asked = asked, 0
    assert text_of(colour_python_lines(text)) == text
    assert not asked, f"{first} tokens again"
