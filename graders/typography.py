"""Typography for plain text: the spaces that must not break in French, and marks piled up on a letter."""

from __future__ import annotations

import re
import unicodedata
from functools import cache, lru_cache

NARROW, WIDE = "\u202f", "\u00a0"
#: Combining marks in a row that are kept, as in Unicode's stream-safe format (UAX 15): no language writes as many.
MAX_MARKS = 30
LONGEST_KEPT = 400  # letters; what is longer may be a student's, and many would fill the memory


def french(text: str) -> str:
    """Make the spaces before `; ! ? : »` and after `«` unbreakable, and curve the apostrophes."""
    return _cached_french(text) if len(text) <= LONGEST_KEPT else _french(text)


def _french(text: str) -> str:
    text = re.sub(r"(?<=\w)'(?=\w)", "’", text)
    text = re.sub(r"[ \u00a0](?=[;!?](?:\W|$))", NARROW, text)
    text = re.sub(r"[ \u202f](?=[:»](?:\W|$))", WIDE, text)
    return re.sub(r"«[ \u202f]", "«" + WIDE, text)


_cached_french = lru_cache(maxsize=16_384)(_french)


def elided(word: str, name: str) -> str:
    """« de », « que » or « le » before the name of a function or a variable: « d’odometrie », « de gain », « de a »."""
    is_elided = len(name) > 1 and unaccented(name).startswith(tuple("aeiou"))
    return f"{word[:-1]}’{name}" if is_elided else f"{word} {name}"


def unaccented(text: str) -> str:
    """Small letters of ASCII: « Nœud d’arrêt » without its accents, its ligature taken apart; the rest is dropped."""
    spelt = text.lower().replace("œ", "oe")  # which Unicode does not take apart
    return unicodedata.normalize("NFKD", limit_marks(spelt)).encode("ascii", "ignore").decode()


def limit_marks(text: str) -> str:
    """Return a text without the combining marks that follow `MAX_MARKS` others: to normalise a run of them takes the
    square of its length."""
    return text if text.isascii() else _excessive_marks().sub(r"\1", text)


@cache
def _excessive_marks() -> re.Pattern[str]:
    marks = "".join(letter for letter in map(chr, range(0x300, 0x1F000)) if unicodedata.combining(letter))
    return re.compile(f"([{marks}]{{{MAX_MARKS}}})[{marks}]+")
