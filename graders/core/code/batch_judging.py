"""Batch judging: many numeric answers are compared with the expected ones by a few array operations.

Answers near the tolerance, neither clearly right nor clearly wrong, are left to the comparison case by case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from graders.core.compare.comparison import WELL_BEYOND, WELL_WITHIN, Comparator, RowComparator
from graders.core.contract.program import Answer, PlannedCalls, Reply
from graders.core.contract.rows import ArrayReplies, Rows
from graders.core.contract.values import Arguments, Floats, Value

#: Numbers of an answer that may be held back to be judged with others.
MAX_BATCHED_ITEMS = 2500


def concatenate_blocks(blocks: Iterable[Sequence[Answer]]) -> Sequence[Answer]:
    """Return the answers of all blocks, as one array where all of them are numbers of one shape."""
    block_list = list(blocks)
    return _concatenate_arrays(block_list) or [answer for block in block_list for answer in block]


def take_leading_plain_answers(blocks: Iterator[Sequence[Answer]]) -> Sequence[Answer]:
    """Return the answers up to the first block with one that is not plain, that block included."""
    plain: list[Sequence[Answer]] = []
    for answers in blocks:
        plain.append(answers)
        if not _are_small_numbers(answers):
            break
    return concatenate_blocks(plain)


def judge_batch(
    batch: PlannedCalls, answers: Sequence[Answer], expected: Callable[..., Value], compare: Comparator
) -> Sequence[bool | None]:
    """Return whether each answer is right; None for one that must be compared alone.

    Empty where the batch cannot be judged at once, or is incomplete. `expected` takes arrays, one case a row.
    """
    if not isinstance(answers, ArrayReplies) or not isinstance(compare, RowComparator):
        return ()
    if not 0 < len(batch.calls) == len(answers) or not _are_small_numbers(answers):
        return ()
    expected_rows, got = np.asarray(expected(*_argument_columns(batch.calls))), answers.values
    errors = compare.row_errors(expected_rows, got) if expected_rows.shape == got.shape else None
    if errors is None:
        return ()
    if (errors <= WELL_WITHIN).all():
        return [True] * len(errors)
    return [True if error <= WELL_WITHIN else False if error >= WELL_BEYOND else None for error in errors.tolist()]


def answer_value(answer: Answer) -> Value:
    """Return the value of a reply; None for a fault."""
    return answer.value if isinstance(answer, Reply) else None


def _argument_columns(calls: Sequence[Arguments]) -> Iterable[Floats]:
    return calls.columns if isinstance(calls, Rows) else map(np.array, zip(*calls, strict=True))


def _are_small_numbers(answers: Sequence[Answer]) -> bool:
    """Whether all answers are numbers, or small arrays of numbers."""
    if isinstance(answers, ArrayReplies):
        return answers.values[:1].size <= MAX_BATCHED_ITEMS
    return all(
        isinstance(value, float)
        or (type(value) is np.ndarray and value.dtype == np.float64 and value.size <= MAX_BATCHED_ITEMS)
        for value in map(answer_value, answers)
    )


def _concatenate_arrays(blocks: Sequence[Sequence[Answer]]) -> ArrayReplies | None:
    """Return all answers as one array; None unless all are floats or arrays of one shape, without arguments."""
    arrays: list[Floats] = []
    for block in blocks:
        array = block.values if isinstance(block, ArrayReplies) else _to_plain_array(block)
        if array is None or (arrays and array.shape[1:] != arrays[0].shape[1:]):
            return None
        arrays.append(array)
    if not arrays:
        return None
    return ArrayReplies(arrays[0] if len(arrays) == 1 else np.concatenate(arrays))


def _to_plain_array(answers: Sequence[Answer]) -> Floats | None:
    if not all(isinstance(answer, Reply) and answer.arguments is None for answer in answers):
        return None
    values = list(map(answer_value, answers))
    types = set(map(type, values))
    if types == {float}:
        return np.array(values)
    if types != {np.ndarray} or any(value.dtype != np.float64 or not value.ndim for value in values):
        return None
    return np.array(values) if len({value.shape for value in values}) == 1 else None
