"""Files in which a letter has more marks than any language writes.

Python normalises names, in the square of the length of a run of combining marks: 64 KB of them take it half a minute,
wherever the file is parsed.
"""

from __future__ import annotations

import re
import unicodedata
from functools import cache

#: Combining marks in a row that are accepted, as in Unicode's stream-safe format (UAX 15).
MAX_MARKS = 30


def find_piled_marks(source: bytes) -> int | None:
    """Return the line of the first letter that has too many marks; None where there is none."""
    if source.isascii():
        return None
    found = _piled_marks().search(text := source.decode(errors="replace"))
    return None if found is None else text.count("\n", 0, found.start()) + 1


def has_piled_marks(text: str) -> bool:
    """Whether a letter has too many marks: to normalise the text, as Python does with names, would take for ever."""
    return not text.isascii() and _piled_marks().search(text) is not None


@cache
def _piled_marks() -> re.Pattern[str]:
    marks = "".join(letter for letter in map(chr, range(0x300, 0x1F000)) if unicodedata.combining(letter))
    return re.compile(f"[{marks}]{{{MAX_MARKS + 1}}}")
