"""Extracts of students' programs that may be shown to others: without anything that identifies their authors."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Collection, Iterable, Iterator, Sequence
from keyword import iskeyword

from graders.typography import limit_marks
from server.text.python_colours import COMMENT, STRINGS, split_into_coloured_tokens

MAX_LINES = 16
MAX_LINE_LENGTH = 100
MAX_CHARACTERS = 8_000  # of a function, before it is tokenised
MIN_NAME_LENGTH = 3
STRING_PLACEHOLDER, NAME_PLACEHOLDER, CUT_MARK = "'…'", "nom", "# …"
WORD = re.compile(r"[^\W\d_]+")


def extract_function(code: str, names: Collection[str]) -> str:
    """Return the text of the first of these functions or classes defined at top level; empty where none is."""
    return find_function(code, names)[1]


def find_function(code: str, names: Collection[str]) -> tuple[int, str]:
    """Return the number (from 1) of its first line, and the text, of the first of these functions or classes.

    Functions within others are not looked for; the text is empty where none is defined.
    """
    lines = code.split("\n")
    heads = tuple(f"{keyword} {name}" for name in names for keyword in ("def", "class"))
    starts = [index for index, line in enumerate(lines) if line.startswith(heads) and _defines_whole_name(line, heads)]
    if not starts:
        return 0, ""
    body = lines[starts[0] + 1 :]
    ends = (index for index, line in enumerate(body) if line and not line[0].isspace() and line[0] not in ")]}#")
    text = "\n".join([lines[starts[0]], *body[: next(ends, len(body))]])[:MAX_CHARACTERS].rstrip()
    return starts[0] + 1, text


def _defines_whole_name(line: str, heads: Collection[str]) -> bool:
    """Whether a head is not followed by more characters of a name."""
    return any(line.startswith(head) and not line[len(head) :][:1].isidentifier() for head in heads)


def folded_name_words(people: Iterable[str]) -> frozenset[str]:
    """Return the words of people's names, folded, for `anonymise_extract`."""
    return frozenset(_fold_word(word) for name in people for word in WORD.findall(name) if len(word) >= MIN_NAME_LENGTH)


def anonymise_extract(code: str, people_words: Collection[str]) -> str:
    """Return the first lines of a program without comments, strings and words of people's names."""
    return "\n".join(text for _, text in anonymise_lines(code, people_words))


def anonymise_lines(code: str, people_words: Collection[str]) -> Sequence[tuple[int, str]]:
    """Return the same lines with their numbers from 0 in the program; the last says where more were cut."""
    text = "".join(_anonymise_tokens(code, people_words))
    lines = [(index, line.rstrip()) for index, line in enumerate(text.split("\n"))]
    lines = [(index, line) for index, line in lines if line and line.strip() != STRING_PLACEHOLDER]
    shown = [(index, _cut_long_line(line)) for index, line in lines[:MAX_LINES]]
    return [*shown, (lines[MAX_LINES][0], CUT_MARK)] if len(lines) > MAX_LINES else shown


def _cut_long_line(line: str) -> str:
    return line if len(line) <= MAX_LINE_LENGTH else line[:MAX_LINE_LENGTH] + " …"


def _anonymise_tokens(code: str, people_words: Collection[str]) -> Iterator[str]:
    in_string = False
    for style, text in split_into_coloured_tokens(code):
        if style in STRINGS:
            yield ("" if in_string else STRING_PLACEHOLDER) + "\n" * text.count("\n")
        elif style != COMMENT:
            yield WORD.sub(lambda word: _anonymise_word(word[0], people_words), text)
        in_string = style in STRINGS


def _anonymise_word(word: str, people_words: Collection[str]) -> str:
    return NAME_PLACEHOLDER if not iskeyword(word) and _fold_word(word) in people_words else word


def _fold_word(word: str) -> str:
    """Return a word in small letters without accents."""
    letters = unicodedata.normalize("NFKD", limit_marks(word.casefold()))
    return "".join(letter for letter in letters if not unicodedata.combining(letter))
