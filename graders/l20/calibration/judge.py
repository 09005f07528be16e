"""Three constants, each said by its name in what is wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graders.core.compare.comparison import Mismatch, are_close, shape_mismatch, unreadable
from graders.core.compare.told_apart import got_instead_of_expected_text
from graders.core.contract.values import UnreadableError, Value, read_array

NAMES = ("γ", "β", "α")
TOLERANCE = 1e-6


@dataclass(frozen=True)
class SameConstants:
    """Three numbers in a tuple, a list or an array, each within the tolerance."""

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        try:
            found = read_array(got)
        except UnreadableError as error:
            return unreadable(error)
        wanted = read_array(expected)
        if found.shape != wanted.shape:
            return shape_mismatch(wanted, found)
        right = [are_close(a, b, TOLERANCE) for a, b in zip(wanted, found, strict=True)]
        if all(right):
            return None
        told = (
            f"{name} : c'est juste." if same else f"{name} : {got_instead_of_expected_text(float(a), float(b))}."
            for name, same, a, b in zip(NAMES, right, wanted, found, strict=True)
        )
        return Mismatch(" ".join(told), "nan" if np.any(np.isnan(found)) else None)
