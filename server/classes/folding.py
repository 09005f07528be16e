"""Compare names whatever their accents, case and punctuation."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

from graders.typography import limit_marks
from server.classes.models import NAME_LENGTH


def normalise_name(text: str) -> str:
    """Fold accents, case and punctuation, so that two spellings of a name compare equal."""
    return _cached_fold(text) if len(text) <= NAME_LENGTH else _fold_uncached(text)


def _fold_uncached(text: str) -> str:
    plain = "".join(
        sign for sign in unicodedata.normalize("NFKD", limit_marks(text)) if not unicodedata.combining(sign)
    )
    return " ".join(re.findall(r"\w+", plain.casefold().replace("_", " ")))


_cached_fold = lru_cache(maxsize=8192)(_fold_uncached)
