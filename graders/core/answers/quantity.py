"""The quantity that one numeric question asks for, and its tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Data = Mapping[str, float]
Values = Mapping[str, float]
#: From the data and the answers to earlier questions to a value.
Formula = Callable[[Data, Values], float]


@dataclass(frozen=True)
class Quantity:
    """The quantity that one question asks for, and how an answer is judged.

    `expected(data, earlier)` computes it with `reference/`; `earlier` holds the values of the questions before it.
    An answer is right within `abs` + `rel` |value| (modulo 2π for an `angle`). `slips` are wrong formulas, by the
    misconception that they show.
    """

    id: str
    points: float
    expected: Formula
    rel: float = 0.01
    abs: float = 0.0
    angle: bool = False
    slips: Mapping[str, Formula] = field(default_factory=dict)

    def is_within_tolerance(self, value: float, other: float, times: float = 1.0) -> bool:
        """Whether `value` is `other`, within so many `times` the tolerance on `other`."""
        gap = math.remainder(value - other, 2.0 * math.pi) if self.angle else value - other
        return abs(gap) <= times * self.tolerance(other)

    def tolerance(self, value: float) -> float:
        return self.abs + self.rel * abs(math.remainder(value, 2.0 * math.pi) if self.angle else value)
