"""Many calls, or many answers, as arrays with one a row; single items are made on first access.

A check of many small calls costs what its arrays cost, as long as no single call is accessed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import overload

import numpy as np

from graders.core.contract.program import Answer, Reply
from graders.core.contract.values import Arguments, Floats, Value


class Rows(Sequence[Arguments]):
    """Calls by columns: for each argument, its values in all calls (n, …). Repeated access gives the same objects.

    Raises TypeError for dtypes other than float64.
    """

    def __init__(self, *columns: Floats) -> None:
        if any(column.dtype != np.float64 for column in columns):
            raise TypeError(f"rows of {', '.join(str(column.dtype) for column in columns)}: float64 is asked for")
        self.columns = columns

    @cached_property
    def _all_calls(self) -> list[Arguments]:
        return list(zip(*map(split_rows, self.columns), strict=True))

    def __len__(self) -> int:
        return len(self.columns[0])

    @overload
    def __getitem__(self, index: int) -> Arguments: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Arguments]: ...
    def __getitem__(self, index: int | slice) -> Arguments | Sequence[Arguments]:
        return self._all_calls[index]

    def __iter__(self) -> Iterator[Arguments]:
        return iter(self._all_calls)


class ArrayReplies(Sequence[Answer]):
    """Replies that are all floats, or arrays of floats of one shape: `values` (n, …); without arguments."""

    def __init__(self, values: Floats) -> None:
        self.values = values

    @cached_property
    def _all_replies(self) -> list[Answer]:
        return [Reply(value) for value in split_rows(self.values)]

    def __len__(self) -> int:
        return len(self.values)

    @overload
    def __getitem__(self, index: int) -> Answer: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Answer]: ...
    def __getitem__(self, index: int | slice) -> Answer | Sequence[Answer]:
        return self._all_replies[index]

    def __iter__(self) -> Iterator[Answer]:
        return iter(self._all_replies)


def as_rows(calls: Sequence[Arguments]) -> Sequence[Arguments]:
    """Return the calls as Rows where each argument is an array of floats of one shape; unchanged otherwise."""
    columns = list(zip(*calls, strict=False))
    alike = len(set(map(len, calls))) == 1 and all(map(_are_float_arrays_of_one_shape, columns))
    return Rows(*map(np.array, columns)) if columns and alike else calls


def _are_float_arrays_of_one_shape(column: Sequence[Value]) -> bool:
    arrays = all(type(value) is np.ndarray and value.dtype == np.float64 and value.ndim for value in column)
    return arrays and len({value.shape for value in column}) == 1


def split_rows(values: Floats) -> list[Value]:
    """Return the rows as a list of floats or of arrays."""
    return values.tolist() if values.ndim == 1 else list(values)
