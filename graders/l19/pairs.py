"""Functions of module L19 return pairs, such as a mean and a covariance: how they are compared, and read by probes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graders.core.code.probes import AnswerRule, ProbeAnswer, ProbeResults, measurement_rule, to_finite_array
from graders.core.compare import words as render
from graders.core.compare.comparison import TOLERANCE, Mismatch, are_close, unreadable, worst_difference
from graders.core.compare.told_apart import got_instead_of_expected_text
from graders.core.contract.values import Arguments, Floats, UnreadableError, Value, is_single_number_array, read_array

#: What two answers to a probe may differ by and still be the same.
ALIKE = 1e-7
#: Characters of a name that is a symbol, such as b or d².
LONGEST_SYMBOL = 2


class NotAPairError(Exception):
    """A value that is not made of two things; its text says so in French."""


@dataclass(frozen=True)
class SamePair:
    """A pair of numbers or of arrays within the tolerance, each said by its name in what is wrong.

    A tuple, a list, or an array of two. Where it is `loose`, a row (1, n) or a column (n, 1) is read as (n,), and (1,)
    as a number. Of the value that is not `judged` (0 or 1; both by default), only its being there counts.
    """

    names: tuple[str, str]
    tolerance: float = TOLERANCE
    loose: bool = False
    judged: int | None = None

    def __call__(self, expected: Value, got: Value) -> Mismatch | None:
        try:
            found = read_pair(got, self.names, loose=self.loose)
        except UnreadableError as error:
            return unreadable(error)
        except NotAPairError as error:
            return Mismatch(str(error), "forme")
        wanted = [read_array(one) for one in expected]
        items = [*got]
        for k, (wish, item) in enumerate(zip(wanted, items, strict=True)):
            if not wish.ndim and is_single_number_array(item):  # such as a product of matrices gives
                found[k] = found[k].reshape(())
        judged = range(2) if self.judged is None else (self.judged,)
        if any(found[k].shape != wanted[k].shape for k in judged):
            return self._wrong_shapes(wanted, found, judged)
        right = {k: are_close(wanted[k], found[k], self.tolerance) for k in judged}
        if all(right.values()):
            return None
        verdicts = [isinstance(each, bool | np.bool_) for each in expected]
        told = " ".join(_told(self.names[k], wanted[k], found[k], right[k], verdicts[k]) for k in judged)
        return Mismatch(told, "nan" if any(np.any(np.isnan(found[k])) for k in judged) else None)

    def _wrong_shapes(self, wanted: Sequence[Floats], found: Sequence[Floats], judged: Sequence[int]) -> Mismatch:
        if [one.shape for one in found[::-1]] == [one.shape for one in wanted]:
            return Mismatch(f"Dans quel ordre ? On attend ({self.names[0]}, {self.names[1]}).", "forme")
        told = [
            f"{self.names[k]} : la forme est {render.shape_text(found[k].shape)} au lieu de "
            f"{render.shape_text(wanted[k].shape)}."
            for k in judged
            if wanted[k].shape != found[k].shape
        ]
        return Mismatch(" ".join(one[0].upper() + one[1:] for one in told), "forme")


def _told(name: str, wanted: Floats, found: Floats, right: bool, is_verdict: bool) -> str:
    """One sentence on one of the two; `is_verdict`: True or False is awaited. A symbol, such as b, stays as it is."""
    name = name if len(name) <= LONGEST_SYMBOL else name[0].upper() + name[1:]
    if right:
        return f"{name} : c'est juste."
    if found.ndim == 0:
        if np.isnan(found):
            return f"{name} : « nan », qui n'est pas un nombre, au lieu de {render.number(float(wanted))}."
        if is_verdict and float(found) in (0.0, 1.0):
            return f"{name} : {bool(found)} au lieu de {bool(wanted)}."
        return f"{name} : {got_instead_of_expected_text(float(wanted), float(found))}."
    gap = worst_difference(wanted, found)
    return f"{name} : {gap[0].lower()}{gap[1:]}"


def read_pair(value: Value, names: tuple[str, str], *, loose: bool = False) -> list[Floats]:
    """A tuple, a list or an array of two as two float arrays, whatever their shapes.

    Raises UnreadableError for what holds no real numbers, NotAPairError for numbers that are not a pair.
    """
    items = list(value) if isinstance(value, np.ndarray) and value.ndim else value
    if not isinstance(items, tuple | list) or len(items) != 2:
        raise NotAPairError(f"La fonction renvoie {_counted(items)} : on attend la paire ({names[0]}, {names[1]}).")
    return [_read_item(*pair, loose=loose) for pair in zip(names, items, strict=True)]


def _counted(items: Value) -> str:
    if not isinstance(items, tuple | list):
        _ = read_array(items)
        return "un seul nombre"
    return f"{len(items)} valeurs" if len(items) > 1 else "une seule valeur"


def _read_item(name: str, item: Value, *, loose: bool) -> Floats:
    if item is None:
        raise UnreadableError(f"{name} vaut None au lieu d'un nombre ou d'un tableau")
    array = read_array(item)
    if loose and array.ndim and array.shape[0] == 1:
        return array.reshape(array.shape[1:])
    return array.ravel() if loose and array.ndim == 2 and array.shape[1] == 1 else array


@dataclass(frozen=True)
class ReadPair:
    """What probes compare: both values, or in words what is no pair. Shapes are those of the exercise's answers."""

    names: tuple[str, str]
    loose: bool = False

    def __call__(self, args: Arguments, value: Value) -> Value:
        try:
            return read_pair(value, self.names, loose=self.loose)
        except (UnreadableError, NotAPairError) as error:
            return str(error)


def part(shown: Sequence[ProbeAnswer], which: int) -> list[Floats] | None:
    """The first or the second value of every answer, None where one is no pair of finite numbers."""
    found = [to_finite_array(one[which]) if isinstance(one, list) and len(one) == 2 else None for one in shown]
    return [one for one in found if one is not None] if all(one is not None for one in found) else None


def agree(ones: Sequence[Floats], others: Sequence[Floats]) -> list[bool]:
    """Which are the same."""
    return [
        one.shape == other.shape and bool(np.allclose(one, other, ALIKE, ALIKE))
        for one, other in zip(ones, others, strict=True)
    ]


def only(which: int, name: str, places: Sequence[int] | None = None) -> AnswerRule:
    """The name for answers whose other value is always right, and this one wrong in all of these places."""

    @measurement_rule
    def rule(shown: ProbeResults) -> str | None:
        got, right = part(shown.got, which), part(shown.right, which)
        beside, its = part(shown.got, 1 - which), part(shown.right, 1 - which)
        if got is None or right is None or beside is None or its is None or not all(agree(beside, its)):
            return None
        if [one.shape for one in got] != [one.shape for one in right]:
            return None
        same = agree(got, right)
        return name if not any(same[k] for k in (range(len(same)) if places is None else places)) else None

    return rule


def sane(values: Floats | None) -> list[float] | None:
    """Numbers that can be drawn, else None."""
    return None if values is None or not np.all(np.isfinite(values)) else [float(value) for value in values]
