"""Mistakes of the parts of an answer, each recognised alone: one in the mean, another one in the variance.

Two mistakes of which one is in no catalogue match no mutant as a whole. A function that returns several values is then
compared part by part with the mutants of one mistake. Only numbers that are no whole ones count: many mistakes give
the same counts, signs and verdicts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from graders.core.code.mutants import MutantRow
from graders.core.code.probes import ProbeAnswer, same_probe_answer
from graders.core.contract.values import UnreadableError, read_array

#: Wrong answers of a part that make it a mutant's.
MIN_WRONG = 2


def match_wrong_parts(
    got: Sequence[ProbeAnswer],
    right: Sequence[ProbeAnswer],
    rows: Callable[[], Sequence[tuple[MutantRow, Sequence[ProbeAnswer]]]],
) -> Iterator[list[MutantRow]]:
    """Yield, for each wrong part of the answers that some mutants reproduce, these mutants.

    `rows` returns the mutants with their answers; it is called once there is a part to compare.
    """
    size = _count_parts(right)
    if not size or _count_parts(got) != size:
        return
    wrong = {
        part: [
            k
            for k, (mine, its) in enumerate(zip(got, right, strict=True))
            if not same_probe_answer(mine[part], its[part])
        ]
        for part in range(size)
    }
    judged = [
        part
        for part in range(size)
        if len(wrong[part]) >= MIN_WRONG and _has_fractional_number(got[k][part] for k in wrong[part])
    ]
    sound = [part for part in range(size) if not wrong[part]]
    mutants = [
        (row, its)
        for row, its in (rows() if judged else ())
        # A mistake that spoils a part which is right here is another one, and its words are about that part.
        if _count_parts(its) == size and _agree_in_parts(got, its, sound)
    ]
    for part in judged:
        fits = [row for row, its in mutants if _agree_in_parts(got, its, [part])]
        if fits:
            yield fits


def _agree_in_parts(got: Sequence[ProbeAnswer], its: Sequence[ProbeAnswer], parts: Sequence[int]) -> bool:
    """Whether two programs answer every probe alike in these parts."""
    return all(
        same_probe_answer(mine[part], other[part]) for mine, other in zip(got, its, strict=True) for part in parts
    )


def _count_parts(answers: Sequence[ProbeAnswer]) -> int:
    """Return of how many parts each answer is made; 0 where they differ, or are made of none."""
    sizes = {len(answer) if isinstance(answer, list | tuple) else 0 for answer in answers}
    return sizes.pop() if len(sizes) == 1 else 0


def _has_fractional_number(parts: Iterator[ProbeAnswer]) -> bool:
    """Whether some of these values are numbers, of which not all are whole."""
    for part in parts:
        try:
            numbers = read_array(part)
        except UnreadableError:
            continue
        if numbers.size and np.isfinite(numbers).all() and np.any(numbers != np.round(numbers)):
            return True
    return False
