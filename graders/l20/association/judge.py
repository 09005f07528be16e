"""Associations: one whole number a measurement, said pair by pair where they differ."""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.compare.comparison import Mismatch, unreadable
from graders.core.contract.values import UnreadableError, Value, read_indices


@dataclass(frozen=True)
class SameAssociation:
    """The same landmark, or none (-1), for every measurement."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        try:
            found = read_indices(got)
        except UnreadableError as error:
            return unreadable(error)
        wanted = list(expected)
        if found == wanted:
            return None
        if len(found) != len(wanted):
            return Mismatch(f"On attend un entier par mesure, {len(wanted)} en tout : il y en a {len(found)}.", "forme")
        i = next(i for i, (a, b) in enumerate(zip(wanted, found, strict=True)) if a != b)
        return Mismatch(f"La mesure {i} {_goes(wanted[i])} : votre réponse {_says(found[i])}.")


def _goes(landmark: int) -> str:
    return "ne va à aucun amer" if landmark < 0 else f"va à l'amer {landmark}"


def _says(landmark: int) -> str:
    return f"ne lui en donne aucun ({landmark})".replace("-", "−") if landmark < 0 else f"est l'amer {landmark}"
