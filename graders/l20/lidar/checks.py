"""Checks on rays: each distance within a tenth of a cell, never beyond the range, told by what stops the ray."""

from __future__ import annotations

import math
from dataclasses import dataclass

from graders.core.code.checks import Cases, Failure, Rejection
from graders.core.compare import words as render
from graders.core.compare.comparison import Mismatch, unreadable
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.findings import FigureData
from graders.core.contract.program import Answer, Reply
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, read_scalar
from graders.l20.lidar.cases import Grid, distance

#: What the statement says, and what is accepted: a march in 120 steps over 12 cells has steps of 12/119.
STATED, ACCEPTED = 0.1, 0.102
#: The contract's room above the range.
ROUNDING = 1e-6
JUST_BEYOND = 1e-6


@dataclass(frozen=True)
class SameDistance:
    """One number, at most `accepted` away from the right distance; within `stated`, says the message."""

    accepted: float = ACCEPTED
    stated: str = "0,1 case d’écart"

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        try:
            value = read_scalar(got)
        except UnreadableError as error:
            return unreadable(error)
        if math.isnan(value):
            return Mismatch("« nan » n’est pas une distance.", "nan")
        if abs(value - expected) <= self.accepted:
            return None
        if math.isinf(value):
            return Mismatch("Une distance infinie n’est jamais lue : au pire, le lidar lit sa portée.")
        gap = render.number(abs(value - expected), 3)
        side = "trop loin" if value > expected else "trop près"
        return Mismatch(f"C’est {gap} {_cells(abs(value - expected))} {side} ; on accepte {self.stated}.")


@dataclass(frozen=True, kw_only=True)
class Rays(Cases):
    """Cases of `lancer_rayon`, told in words."""

    def _find_failure(self, args: Arguments, answer: Answer) -> Failure | None:
        failure = super()._find_failure(args, answer)
        if failure is not None or not isinstance(answer, Reply):
            return failure
        expected, portee_max = self.expected(*args), args[4]
        if read_scalar(answer.value) <= portee_max + ROUNDING:
            return None
        mismatch = Mismatch("Une distance lue ne dépasse jamais la portée, même de peu.")
        return Failure(args, expected, answer.value, mismatch, None)

    def _rejection(self, failure: Failure) -> Rejection:
        rejection = super()._rejection(failure)
        if failure.mismatch is not None:
            told = f"{asked(failure.args)} {read(failure.args, failure.expected)}"
            obtained = f"{self.function} renvoie {value_text_pair(failure.expected, failure.got)[1]}."
            rejection.message = f"{told} {obtained} {failure.mismatch.message}"
            rejection.args = (rejection.message,)
        return rejection


def _cells(length: float) -> str:
    return "case" if length < 2.0 else "cases"


def _place(x: float, y: float) -> str:
    return f"({render.number(x, 4)} ; {render.number(y, 4)})"


def asked(args: Arguments) -> str:
    """« Depuis (x, y) = (2,3 ; 3,7), dans la direction π/2 rad (90°), avec une portée de 12 cases : »."""
    _, x, y, angle, portee_max = args
    range_ = f"{render.number(portee_max)} {_cells(portee_max)}"
    return f"Depuis (x, y) = {_place(x, y)}, dans la direction {render.angle(angle)}, avec une portée de {range_} :"


def read(args: Arguments, expected: float) -> str:
    """What the ray meets and where, or that it meets nothing."""
    libres, x, y, angle, portee_max = args
    length = f"{render.number(expected, 5)} {_cells(expected)}"
    if expected >= portee_max:
        return f"le rayon ne touche rien avant la portée, et lit donc {render.number(expected, 5)}."
    end = _place(x + expected * math.cos(angle), y + expected * math.sin(angle))
    return f"le premier mur est à {length}, au point {end} : {_what_stops(libres, x, y, angle, expected)}."


def _what_stops(libres: Grid, x: float, y: float, angle: float, expected: float) -> str:
    column = math.floor(x + (expected + JUST_BEYOND) * math.cos(angle))
    row = math.floor(y + (expected + JUST_BEYOND) * math.sin(angle))
    height, width = libres.shape
    if 0 <= row < height and 0 <= column < width:
        return f"la case libres[{row}, {column}] est un mur"
    return "le rayon y sort de la grille"


def ray_figure(args: Arguments, expected: Value, got: Floats | None) -> FigureData:
    """What is drawn of one ray: the map, the way that it goes, where it must end and where it ended."""
    libres, x, y, angle, _ = args
    return {"kind": "ray", "free": libres, "start": [x, y], "angle": angle, "expected": expected,
            "got": None if got is None else float(got)}  # fmt: skip


def expected_distance(libres: Grid, x: float, y: float, angle: float, portee_max: float) -> float:
    """The right answer, from the arguments in their order."""
    return distance(libres, x, y, angle, portee_max)
