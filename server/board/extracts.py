"""Pieces of students' programs that may be shown to others: without what says whose they are."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator
from functools import cache

from pygments.lexer import Lexer
from pygments.token import Comment, Name, String, _TokenType

MAX_LINES = 16
MAX_LINE_LENGTH = 100
MAX_CHARACTERS = 8_000  # of a function, before anything is read in it
MIN_NAME_LENGTH = 3
TEXT, SOMEBODY, MORE = "'…'", "nom", "# …"
WORD = re.compile(r"[^\W\d_]+")


@cache
def _lexer() -> Lexer:
    """Python's is slow to load: when somebody looks."""
    from pygments.lexers.python import PythonLexer

    return PythonLexer(stripnl=False, ensurenl=False)


def extract_function(code: str, names: Collection[str]) -> str:
    """The text of the first of these functions that is defined at the beginning of a line; empty where none is."""
    lines = code.split("\n")
    heads = tuple(f"{word} {name}" for name in names for word in ("def", "class"))
    starts = [place for place, line in enumerate(lines) if line.startswith(heads) and _ends(line, heads)]
    if not starts:
        return ""
    body = lines[starts[0] + 1 :]
    ends = (place for place, line in enumerate(body) if line and not line[0].isspace() and line[0] not in ")]}#")
    return "\n".join([lines[starts[0]], *body[: next(ends, len(body))]])[:MAX_CHARACTERS].rstrip()


def _ends(line: str, heads: Collection[str]) -> bool:
    """Whether what follows the name is not more of a name."""
    return any(line.startswith(head) and not line[len(head) :][:1].isidentifier() for head in heads)


def name_words(people: Iterable[str]) -> frozenset[str]:
    """Of which somebody's name is made: for `anonymous`."""
    return frozenset(_plain(word) for name in people for word in WORD.findall(name) if len(word) >= MIN_NAME_LENGTH)


def anonymise_extract(code: str, people: Collection[str]) -> str:
    """The same without comments, nor texts, nor words that are part of somebody's name; some lines at most."""
    text = "".join(_written(code, people))
    lines = [line.rstrip() for line in text.split("\n")]
    told = [line for line in lines if line and line.strip() != TEXT]
    cut = [line if len(line) <= MAX_LINE_LENGTH else line[:MAX_LINE_LENGTH] + " …" for line in told[:MAX_LINES]]
    return "\n".join([*cut, *([MORE] if len(told) > MAX_LINES else [])])


def _written(code: str, known: Collection[str]) -> Iterator[str]:
    in_text = False
    for kind, value in _lexer().get_tokens(code):
        if _is(kind, String):
            yield "" if in_text else TEXT
        elif not _is(kind, Comment):
            yield _unnamed(kind, value, known)
        in_text = _is(kind, String)


def _unnamed(kind: _TokenType, value: str, known: Collection[str]) -> str:
    if not _is(kind, Name):
        return value
    return WORD.sub(lambda word: SOMEBODY if _plain(word[0]) in known else word[0], value)


def _plain(word: str) -> str:
    """As one writes it in a program: in small letters, without accents."""
    letters = unicodedata.normalize("NFKD", word.casefold())
    return "".join(letter for letter in letters if not unicodedata.combining(letter))


def _is(kind: _TokenType, of: _TokenType) -> bool:
    """Whether a token is of a kind, or of one below it."""
    return kind[: len(of)] == of
