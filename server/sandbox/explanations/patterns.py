"""Texts of exceptions, and the functions that say them in French."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from server.sandbox.explanations.types import describe_type

#: From the match of a text and the guilty line to a French sentence.
Explainer = Callable[[re.Match[str], str], str]
Pattern = tuple[str, Explainer]

NUMBER = r"(?:\d+(?:\.\d*)?|\.\d+)"
OR_NONE = "une fonction sans « return », ou une valeur qui manque ?"


def first_sentence(patterns: Iterable[Pattern], text: str, source: str) -> str | None:
    """Return the sentence of the first pattern that a text matches; None where there is none."""
    for pattern, explain in patterns:
        if match := re.search(pattern, text, re.DOTALL):
            return explain(match, source)
    return None


def said(sentence: str) -> Explainer:
    """Return an explainer whose groups are types of Python, said in French."""
    return lambda match, source: sentence.format(*(describe_type(group) for group in match.groups()))


def told(sentence: str) -> Explainer:
    """Return an explainer whose groups are written as they are."""
    return lambda match, source: sentence.format(*match.groups())


def plural(count: str, word: str) -> str:
    """« 1 nom », « 2 noms »."""
    return f"{count} {word}{'' if count in ('0', '1') else 's'}"


def called_function(source: str) -> str:
    """Return the first function that a line calls, « np.random.choice »; empty for none."""
    match = re.search(
        r"(?<![\w.])((?:[^\W\d]\w*\.)*[^\W\d]\w*)\s*\(", re.sub(r"^\s*(?:def|if|while|for|return)\b", "", source)
    )
    return match[1] if match else ""
