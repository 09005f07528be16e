"""Extracts of students' programs that may be shown to others: without anything that identifies their authors."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator
from functools import cache
from typing import Any

from pygments.lexer import Lexer
from pygments.token import Comment, Name, String

from graders.typography import limit_marks

MAX_LINES = 16
MAX_LINE_LENGTH = 100
MAX_CHARACTERS = 8_000  # of a function, before it is tokenised
MIN_NAME_LENGTH = 3
STRING_PLACEHOLDER, NAME_PLACEHOLDER, CUT_MARK = "'…'", "nom", "# …"
WORD = re.compile(r"[^\W\d_]+")


@cache
def _lexer() -> Lexer:
    """Load Python's lexer lazily, as that is slow."""
    from pygments.lexers.python import PythonLexer

    return PythonLexer(stripnl=False, ensurenl=False)


def extract_function(code: str, names: Collection[str]) -> str:
    """Return the text of the first of these functions or classes defined at top level; empty where none is."""
    lines = code.split("\n")
    heads = tuple(f"{keyword} {name}" for name in names for keyword in ("def", "class"))
    starts = [index for index, line in enumerate(lines) if line.startswith(heads) and _has_whole_name(line, heads)]
    if not starts:
        return ""
    body = lines[starts[0] + 1 :]
    ends = (index for index, line in enumerate(body) if line and not line[0].isspace() and line[0] not in ")]}#")
    return "\n".join([lines[starts[0]], *body[: next(ends, len(body))]])[:MAX_CHARACTERS].rstrip()


def _has_whole_name(line: str, heads: Collection[str]) -> bool:
    """Whether a head is not followed by more characters of a name."""
    return any(line.startswith(head) and not line[len(head) :][:1].isidentifier() for head in heads)


def name_words(people: Iterable[str]) -> frozenset[str]:
    """Return the words of people's names, folded, for `anonymise_extract`."""
    return frozenset(_fold(word) for name in people for word in WORD.findall(name) if len(word) >= MIN_NAME_LENGTH)


def anonymise_extract(code: str, people_words: Collection[str]) -> str:
    """Return the first lines of a program without comments, strings and words of people's names."""
    text = "".join(_anonymise_tokens(code, people_words))
    lines = [line.rstrip() for line in text.split("\n")]
    lines = [line for line in lines if line and line.strip() != STRING_PLACEHOLDER]
    cut = [line if len(line) <= MAX_LINE_LENGTH else line[:MAX_LINE_LENGTH] + " …" for line in lines[:MAX_LINES]]
    return "\n".join([*cut, *([CUT_MARK] if len(lines) > MAX_LINES else [])])


def _anonymise_tokens(code: str, people_words: Collection[str]) -> Iterator[str]:
    in_string = False
    tokens: Iterable[tuple[Any, str]] = _lexer().get_tokens(code)
    for kind, text in tokens:
        if kind in String:
            yield "" if in_string else STRING_PLACEHOLDER
        elif kind in Name:
            yield WORD.sub(lambda word: NAME_PLACEHOLDER if _fold(word[0]) in people_words else word[0], text)
        elif kind not in Comment:
            yield text
        in_string = kind in String


def _fold(word: str) -> str:
    """Return a word in small letters without accents."""
    letters = unicodedata.normalize("NFKD", limit_marks(word.casefold()))
    return "".join(letter for letter in letters if not unicodedata.combining(letter))
