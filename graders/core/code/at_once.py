"""Answers judged at once: of many cases whose answers are plain, all are compared in a few operations of arrays.

What does not show at once to be right, well within the tolerance, or wrong, well beyond, is judged case by case.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from graders.core.compare.comparison import WELL_BEYOND, WELL_WITHIN, Comparator, OfRows
from graders.core.contract.program import Answer, Foreseen, Reply
from graders.core.contract.values import Value

#: Numbers in an answer that may wait to be judged with others.
PLAIN = 2500


def plain_answers(blocks: Iterator[Sequence[Answer]]) -> list[Answer]:
    """The answers up to the first that is not plain, with those that have come with it: none costs much to keep."""
    plain: list[Answer] = []
    for answers in blocks:
        plain += answers
        if not all(map(_is_plain, answers)):
            break
    return plain


def seen_at_once(
    asked: Foreseen, answers: Sequence[Answer], expected: Callable[..., Value], compare: Comparator
) -> Sequence[bool | None]:
    """Which of all the answers are seen to be right, or wrong; None for one that must be judged by itself.

    Empty where they must all be, or are not all there. `expected` takes arrays, one case a row.
    """
    if not isinstance(compare, OfRows) or not 0 < len(asked.calls) == len(answers) or not all(map(_is_plain, answers)):
        return ()
    values = list(map(value_of, answers))
    if len({value.shape if isinstance(value, np.ndarray) else () for value in values}) > 1:
        return ()
    wanted = np.asarray(expected(*map(np.array, zip(*asked.calls, strict=True))))
    got = np.array(values)
    gaps = compare.gaps(wanted, got) if wanted.shape == got.shape else None
    if gaps is None:
        return ()
    return [True if gap <= WELL_WITHIN else False if gap >= WELL_BEYOND else None for gap in gaps.tolist()]


def value_of(answer: Answer) -> Value:
    """What a call returned; None for a fault."""
    return answer.value if isinstance(answer, Reply) else None


def _is_plain(answer: Answer) -> bool:
    """A number, or a small array of numbers."""
    if not isinstance(answer, Reply):
        return False
    value = answer.value
    if type(value) is np.ndarray:
        return value.dtype == np.float64 and value.size <= PLAIN
    return isinstance(value, float)
