"""Answers as arrays, so that many are compared by a few array operations, with the result of `same_probe_answer`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from graders.core.code.probes import TOLERANCE, ProbeAnswer, ProbeFault, same_probe_answer
from graders.core.contract.values import Floats, UnreadableError, near, read_array

Shape = tuple[int, ...]


class AnswerSequence:
    """Answers one after the other: the numbers of all, where each can be read as such."""

    def __init__(self, answers: Iterable[ProbeAnswer] = ()) -> None:
        self.answers: list[ProbeAnswer] = []
        self.arrays: list[Floats | None] = []
        for answer in answers:
            self.add(answer)

    def add(self, answer: ProbeAnswer) -> None:
        self.answers.append(answer)
        self.arrays.append(_read(answer))
        for known in ("_shapes", "_numbers", "_begins"):
            self.__dict__.pop(known, None)

    @cached_property
    def _shapes(self) -> tuple[Shape, ...] | None:
        """None where some answer is no array of numbers, or holds none."""
        shapes = tuple(one.shape for one in self.arrays if one is not None and one.size)
        return shapes if len(shapes) == len(self.arrays) else None

    @cached_property
    def _numbers(self) -> Floats:
        return np.concatenate([one.ravel() for one in self.arrays if one is not None])

    @cached_property
    def _begins(self) -> NDArray[np.int64]:
        return np.cumsum([0, *(one.size for one in self.arrays[:-1] if one is not None)])

    def agreement(self, other: AnswerSequence) -> list[bool]:
        """Which of these answers are the same as the other's at their place."""
        count = min(len(self.arrays), len(other.arrays))
        if not count or self._shapes is None or self._shapes != other._shapes:
            return [self.agrees_at(other, k) for k in range(count)]
        same = near(self._numbers, other._numbers, TOLERANCE)
        return list(map(bool, np.logical_and.reduceat(same, self._begins)))

    def agrees_at(self, other: AnswerSequence, k: int) -> bool:
        """Is the k-th of these the same as the other's?"""
        one, its = self.arrays[k], other.arrays[k]
        if one is not None and its is not None:
            return one.shape == its.shape and bool(near(one, its, TOLERANCE).all())
        return one is its and same_probe_answer(self.answers[k], other.answers[k])


class AnswerColumn:
    """What many programs answer to one call: those that answer the same are found at once."""

    def __init__(self, answers: Sequence[ProbeAnswer]) -> None:
        self._answers = answers
        self._unread: list[int] = []
        self._places: dict[Shape, list[int]] = {}
        read = list(map(_read, answers))
        for place, one in enumerate(read):
            (self._unread if one is None else self._places.setdefault(one.shape, [])).append(place)
        self._rows = {
            shape: np.array([read[place] for place in places], dtype=np.float64).reshape(len(places), -1)
            for shape, places in self._places.items()
        }

    def indices_of(self, answer: ProbeAnswer) -> list[int]:
        """The places of those that are the same as this one."""
        one = _read(answer)
        if one is None:
            return [place for place in self._unread if same_probe_answer(self._answers[place], answer)]
        if one.shape not in self._rows:
            return []
        places = self._places[one.shape]
        same = near(self._rows[one.shape], one.ravel(), TOLERANCE).all(axis=1)
        return [places[k] for k in np.flatnonzero(same)]


def _read(answer: ProbeAnswer) -> Floats | None:
    """None of what is no array of numbers."""
    if isinstance(answer, ProbeFault):
        return None
    try:
        return read_array(answer)
    except UnreadableError:
        return None
