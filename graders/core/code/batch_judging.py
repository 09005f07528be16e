"""Answers judged at once: of many cases whose answers are plain, all are compared in a few operations of arrays.

What does not show at once to be right, well within the tolerance, or wrong, well beyond, is judged case by case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from graders.core.compare.comparison import WELL_BEYOND, WELL_WITHIN, Comparator, RowComparator
from graders.core.contract.program import Answer, PlannedCalls, Reply
from graders.core.contract.rows import ArrayReplies, Rows
from graders.core.contract.values import Arguments, Floats, Value

#: Numbers in an answer that may wait to be judged with others.
MAX_BATCHED_ITEMS = 2500


def concatenate_blocks(blocks: Iterable[Sequence[Answer]]) -> Sequence[Answer]:
    """The answers of all blocks, as one array where that is what they are."""
    taken = list(blocks)
    return _joined(taken) or [answer for answers in taken for answer in answers]


def take_plain_answers(blocks: Iterator[Sequence[Answer]]) -> Sequence[Answer]:
    """The answers up to the first that is not plain, with those that have come with it: none costs much to keep."""
    plain: list[Sequence[Answer]] = []
    for answers in blocks:
        plain.append(answers)
        if not _is_plain(answers):
            break
    return concatenate_blocks(plain)


def judge_batch(
    asked: PlannedCalls, answers: Sequence[Answer], expected: Callable[..., Value], compare: Comparator
) -> Sequence[bool | None]:
    """Which of all the answers are seen to be right, or wrong; None for one that must be judged by itself.

    Empty where they must all be, or are not all there. `expected` takes arrays, one case a row.
    """
    if not isinstance(answers, ArrayReplies) or not isinstance(compare, RowComparator):
        return ()
    if not 0 < len(asked.calls) == len(answers) or not _is_plain(answers):
        return ()
    wanted, got = np.asarray(expected(*_columns(asked.calls))), answers.values
    gaps = compare.row_errors(wanted, got) if wanted.shape == got.shape else None
    if gaps is None:
        return ()
    if (gaps <= WELL_WITHIN).all():
        return [True] * len(gaps)
    return [True if gap <= WELL_WITHIN else False if gap >= WELL_BEYOND else None for gap in gaps.tolist()]


def answer_value(answer: Answer) -> Value:
    """What a call returned; None for a fault."""
    return answer.value if isinstance(answer, Reply) else None


def _columns(calls: Sequence[Arguments]) -> Iterable[Floats]:
    return calls.columns if isinstance(calls, Rows) else map(np.array, zip(*calls, strict=True))


def _is_plain(answers: Sequence[Answer]) -> bool:
    """Are all numbers, or small arrays of numbers?"""
    if isinstance(answers, ArrayReplies):
        return answers.values[:1].size <= MAX_BATCHED_ITEMS
    return all(
        isinstance(value, float)
        or (type(value) is np.ndarray and value.dtype == np.float64 and value.size <= MAX_BATCHED_ITEMS)
        for value in map(answer_value, answers)
    )


def _joined(blocks: Sequence[Sequence[Answer]]) -> ArrayReplies | None:
    """The same answers, where all are floats, or arrays of floats of one shape, and no arguments have come back."""
    arrays = [block.values if isinstance(block, ArrayReplies) else _as_rows(block) for block in blocks]
    if not arrays or any(array is None for array in arrays):
        return None
    found = [array for array in arrays if array is not None]
    if any(array.shape[1:] != found[0].shape[1:] for array in found):
        return None
    return ArrayReplies(found[0] if len(found) == 1 else np.concatenate(found))


def _as_rows(answers: Sequence[Answer]) -> Floats | None:
    if not all(isinstance(answer, Reply) and answer.arguments is None for answer in answers):
        return None
    values = list(map(answer_value, answers))
    kinds = set(map(type, values))
    if kinds == {float}:
        return np.array(values)
    if kinds != {np.ndarray} or any(value.dtype != np.float64 or not value.ndim for value in values):
        return None
    return np.array(values) if len({value.shape for value in values}) == 1 else None
