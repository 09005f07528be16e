"""French typography for plain text: the spaces that must not break."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

NARROW, WIDE = "\u202f", "\u00a0"


@lru_cache(maxsize=16384)
def french(text: str) -> str:
    """Make the spaces before `; ! ? : »` and after `«` unbreakable, and curve the apostrophes."""
    text = re.sub(r"(?<=\w)'(?=\w)", "’", text)
    text = re.sub(r"[ \u00a0](?=[;!?](?:\W|$))", NARROW, text)
    text = re.sub(r"[ \u202f](?=[:»](?:\W|$))", WIDE, text)
    return re.sub(r"«[ \u202f]", "«" + WIDE, text)


def unaccented(text: str) -> str:
    """Small letters of ASCII: « Nœud d’arrêt » without its accents, its ligature taken apart; the rest is dropped."""
    spelt = text.lower().replace("œ", "oe")  # which Unicode does not take apart
    return unicodedata.normalize("NFKD", spelt).encode("ascii", "ignore").decode()
