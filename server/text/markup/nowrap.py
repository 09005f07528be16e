"""A comma, a colon, a bracket or a unit stays on the line of the formula that it touches.

A browser may go to the next line before and after each formula, whatever stands there, and even at a space that does
not break: both are put inside one element, which the style sheet holds together.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Literal

from markdown_it.token import Token

UNIT = r"[ \u00a0](?:%|°|(?:[cmk]?m[²³]?|m?s|rad|Hz)(?:/s²?)?(?![\w’]))"
AFTER = re.compile(rf"^(?:{UNIT})?(?:[\u202f\u00a0]?[^\w\s]+)?")
BEFORE = re.compile(r"[^\w\s]+\u00a0?$")
FORMULA = "math_inline"


def keep_punctuation_with_formulas(tokens: Sequence[Token]) -> list[Token]:
    """The parts of a paragraph, each formula in one element with the punctuation around it."""
    done: list[Token] = []
    for index, part in enumerate(tokens):
        if part.type != FORMULA:
            done.append(part)
            continue
        before = _take_adjacent_punctuation(BEFORE, done[-1] if done else None)
        after = _take_adjacent_punctuation(AFTER, tokens[index + 1] if index + 1 < len(tokens) else None)
        if before or after:
            done += [_nowrap_span_token("held_open", 1), *before, part, *after, _nowrap_span_token("held_close", -1)]
        else:
            done.append(part)
    return done


def _take_adjacent_punctuation(pattern: re.Pattern[str], neighbour: Token | None) -> list[Token]:
    """What the neighbour has to lend, taken away from it."""
    if neighbour is None or neighbour.type != "text":
        return []
    match = pattern.search(neighbour.content)
    if match is None or not match[0]:
        return []
    lent = Token("text", "", 0, content=match[0], level=neighbour.level, meta=dict(neighbour.meta))
    neighbour.content = neighbour.content[: match.start()] + neighbour.content[match.end() :]
    return [lent]


def _nowrap_span_token(kind: str, nesting: Literal[-1, 1]) -> Token:
    return Token(kind, "span", nesting, attrs={"class": "held"} if nesting == 1 else {})
