"""Split a full name into family and given name, by its capitals or by the order that its header tells.

Where neither decides, the name stays whole: a name is never cut on a guess.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

PARTICLES = frozenset(
    [
        "de",
        "du",
        "des",
        "d",
        "la",
        "le",
        "les",
        "l",
        "von",
        "van",
        "der",
        "den",
        "ten",
        "zu",
        "zur",
        "da",
        "das",
        "dos",
        "do",
        "di",
        "del",
        "della",
        "dello",
        "el",
        "al",
        "abd",
        "ben",
        "bin",
        "ibn",
        "bou",
        "ould",
        "ait",
        "y",
        "e",
        "st",
        "ste",
        "saint",
        "sainte",
        "mac",
        "mc",
        "o",
        "of",
        "af",
        "av",
        "dit",
        "épouse",
        "ép",
    ]
)
CIVILITIES = re.compile(r"(?:M\.|Mr\.?|MR|Mme\.?|MME|Mlle\.?|MLLE|Monsieur|Madame|Mademoiselle)\s+")
CELTIC = re.compile(r"\b(?:Mc|Mac|Fitz|De|Le|La|Di|Du|Van|O)(?=\W?[^\W\d_]{2,})")


@dataclass(frozen=True)
class SplitName:
    """The two names; `whole` where nothing said where to cut: the family name has it all."""

    family: str
    given: str
    whole: bool = False


def split_full_name(text: str, family_first: bool | None = None) -> SplitName:
    """Split « NOM Prénom » or « Prénom NOM » at its capitals or its comma, else by the order of two names."""
    name = CIVILITIES.sub("", text, count=1) if CIVILITIES.match(text) else text
    before, comma, after = (part.strip() for part in name.partition(","))
    if comma and before and after and "," not in after:
        return SplitName(before, after)
    words = name.split()
    cut = _split_at_capitals(words)
    if cut is not None:
        return cut
    if family_first is not None:
        units = _join_particles(words)
        if len(units) == 2:
            family, given = units if family_first else reversed(units)
            return SplitName(family, given)
    return SplitName(name, "", whole=len(words) > 1)


def _split_at_capitals(words: Sequence[str]) -> SplitName | None:
    kinds = [_classify_name_word(word) for word in words]
    capitals = [place for place, kind in enumerate(kinds) if kind == "upper"]
    if not capitals or "lower" not in kinds:
        return None
    first, last = capitals[0], capitals[-1]
    while first and kinds[first - 1] == "particle":
        first -= 1
    if any(kind == "lower" for kind in kinds[first:last]):
        return None
    if all(kind != "lower" for kind in kinds[:first]):
        first = 0
    family, given = words[first : last + 1], [*words[:first], *words[last + 1 :]]
    if words[:first] and words[last + 1 :]:  # capitals in the middle
        return None
    return SplitName(" ".join(family), " ".join(given))


def _classify_name_word(word: str) -> str:
    """Tell a word in capitals from another one. A single letter, or a word without letters, is neither."""
    letters = [sign for sign in CELTIC.sub("", word) if sign.isalpha() and sign != "ß"]
    bare = word.rstrip("'’").casefold()
    if word.islower() and (bare in PARTICLES or re.match(r"[dl]['’]", word)):
        return "particle"
    letters = [
        sign for sign in re.sub(r"^[dl]['’](?=[^\W\d_])", "", CELTIC.sub("", word)) if sign.isalpha() and sign != "ß"
    ]
    if len(letters) < 2 or not any(sign.isupper() or sign.islower() for sign in letters):
        return "neither" if any(sign.isupper() for sign in letters) or not letters else "lower"
    return "upper" if all(sign.isupper() for sign in letters) else "lower"


def _join_particles(words: Sequence[str]) -> list[str]:
    """Join particles with the word that follows: « De La Tour » is one name."""
    units: list[str] = []
    waiting: list[str] = []
    for word in words:
        waiting.append(word)
        if word.casefold().rstrip("'’") not in PARTICLES:
            units.append(" ".join(waiting))
            waiting = []
    if waiting and units:
        units[-1] = " ".join([units[-1], *waiting])
    return units
