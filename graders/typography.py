"""French typography for plain text: the spaces that must not break."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

NARROW, WIDE = "\u202f", "\u00a0"
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


def unaccented(text: str) -> str:
    """Small letters of ASCII: « Nœud d’arrêt » without its accents, its ligature taken apart; the rest is dropped."""
    spelt = text.lower().replace("œ", "oe")  # which Unicode does not take apart
    return unicodedata.normalize("NFKD", spelt).encode("ascii", "ignore").decode()
