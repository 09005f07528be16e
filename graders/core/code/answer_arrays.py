"""Answers as arrays, so that many are compared by a few array operations, with the result of `same_probe_answer`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from graders.core.code.probes import TOLERANCE, ProbeAnswer, ProbeFault, same_probe_answer
from graders.core.contract.values import Floats, UnreadableError, are_elements_close, read_array

Shape = tuple[int, ...]


class AnswerSequence:
    """The answers of one program, each read as an array of numbers where possible."""

    def __init__(self, answers: Iterable[ProbeAnswer] = ()) -> None:
        self.answers: list[ProbeAnswer] = []
        self.arrays: list[Floats | None] = []
        for answer in answers:
            self.add(answer)

    def add(self, answer: ProbeAnswer) -> None:
        self.answers.append(answer)
        self.arrays.append(_read_answer_array(answer))
        for name in ("_array_shapes", "_all_numbers", "_begin_offsets"):
            self.__dict__.pop(name, None)

    @cached_property
    def _array_shapes(self) -> tuple[Shape, ...] | None:
        """Shapes of the arrays; None where some answer is not a non-empty array of numbers."""
        shapes = tuple(array.shape for array in self.arrays if array is not None and array.size)
        return shapes if len(shapes) == len(self.arrays) else None

    @cached_property
    def _all_numbers(self) -> Floats:
        return np.concatenate([array.ravel() for array in self.arrays if array is not None])

    @cached_property
    def _begin_offsets(self) -> NDArray[np.int64]:
        return np.cumsum([0, *(array.size for array in self.arrays[:-1] if array is not None)])

    def compare_answers(self, other: AnswerSequence) -> list[bool]:
        """Return whether each answer agrees with the other sequence's answer at its index."""
        count = min(len(self.arrays), len(other.arrays))
        if not count or self._array_shapes is None or self._array_shapes != other._array_shapes:
            return [self.agrees_at(other, k) for k in range(count)]
        same = are_elements_close(self._all_numbers, other._all_numbers, TOLERANCE)
        return list(map(bool, np.logical_and.reduceat(same, self._begin_offsets)))

    def agrees_at(self, other: AnswerSequence, k: int) -> bool:
        """Whether the k-th answers agree."""
        own, others = self.arrays[k], other.arrays[k]
        if own is not None and others is not None:
            return own.shape == others.shape and bool(are_elements_close(own, others, TOLERANCE).all())
        return own is others and same_probe_answer(self.answers[k], other.answers[k])


class AnswerColumn:
    """The answers of many programs to one call, searched by value in one array operation."""

    def __init__(self, answers: Sequence[ProbeAnswer]) -> None:
        self._answers = answers
        self._unread: list[int] = []
        self._places: dict[Shape, list[int]] = {}
        arrays = list(map(_read_answer_array, answers))
        for index, array in enumerate(arrays):
            (self._unread if array is None else self._places.setdefault(array.shape, [])).append(index)
        self._rows = {
            shape: np.array([arrays[index] for index in indices], dtype=np.float64).reshape(len(indices), -1)
            for shape, indices in self._places.items()
        }

    def indices_of(self, answer: ProbeAnswer) -> list[int]:
        """Return the indices of the answers that agree with this one."""
        array = _read_answer_array(answer)
        if array is None:
            return [index for index in self._unread if same_probe_answer(self._answers[index], answer)]
        if array.shape not in self._rows:
            return []
        indices = self._places[array.shape]
        same = are_elements_close(self._rows[array.shape], array.ravel(), TOLERANCE).all(axis=1)
        return [indices[k] for k in np.flatnonzero(same)]


def _read_answer_array(answer: ProbeAnswer) -> Floats | None:
    """Read an answer as an array of numbers; None where it is not one."""
    if isinstance(answer, ProbeFault):
        return None
    try:
        return read_array(answer)
    except UnreadableError:
        return None
