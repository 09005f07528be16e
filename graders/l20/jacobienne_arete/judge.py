"""How pairs (A, B) are compared: whole, or one column of one of the two, so that what is right earns its points."""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.compare.comparison import Mismatch, are_close, worst_difference
from graders.core.contract.values import Value, read_array
from graders.l19.pairs import SamePair, read_pair

BOTH, SYSTEM = ("A", "B"), ("H", "b")
#: Of derivatives, which may come from finite differences, and of what is made of them.
DERIVATIVE, PRODUCT = 1e-4, 1e-3
WHOLE = SamePair(BOTH, tolerance=DERIVATIVE)


@dataclass(frozen=True)
class SameColumns:
    """Pairs (A, B) of which the columns `first` to `last` of matrix `which` agree; shapes are those of the whole."""

    which: int
    first: int
    last: int

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        whole = WHOLE(expected, got)
        if whole is None or whole.slip is not None or whole.cause.value != "wrong_answer":
            return whole
        found = read_pair(got, BOTH)[self.which]
        wanted = read_array(expected[self.which])
        if found.shape != wanted.shape:
            return whole
        wanted, found = wanted[:, self.first : self.last], found[:, self.first : self.last]
        if are_close(wanted, found, DERIVATIVE):
            return None
        place = "la dernière colonne" if self.first == 2 else "les deux premières colonnes" if self.last == 2 else ""
        return Mismatch(f"Dans {BOTH[self.which]}{f', {place}' if place else ''} : {_lower(wanted, found)}")


def _lower(wanted: Value, found: Value) -> str:
    told = worst_difference(wanted, found)
    return told[0].lower() + told[1:]
