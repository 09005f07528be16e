"""How far a changed program's answers to probes agree with the right ones, number by number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from graders.core.code.probes import TOLERANCE, ProbeAnswer, ProbeFault, Probes, same_probe_answer
from graders.core.contract.values import Floats, UnreadableError, read_array


def right_numbers(probes: Probes, answer: ProbeAnswer, right: ProbeAnswer) -> NDArray[np.bool_]:
    """Return which numbers of an answer are right: one mark where it is not compared number by number."""
    whole = probes.same(answer, right)
    mine, wanted = _leaves(answer), _leaves(right)
    if probes.same is not same_probe_answer or wanted is None:
        return np.array([whole])
    if whole or mine is None or mine.size != wanted.size:
        return np.full(max(1, wanted.size), whole)
    return np.asarray(np.abs(mine - wanted) <= TOLERANCE * np.maximum(1.0, np.abs(wanted)))


def _leaves(value: ProbeAnswer) -> Floats | None:
    """Return the numbers of an answer in one row; None where it holds anything else."""
    if isinstance(value, list | tuple):
        parts = [_leaves(part) for part in value]
        return np.concatenate(parts) if parts and all(part is not None for part in parts) else None  # type: ignore[arg-type]
    if isinstance(value, ProbeFault | str) or value is None:
        return None
    try:
        return read_array(value).ravel()
    except UnreadableError:
        return None


def is_better(before: Sequence[NDArray[np.bool_]], after: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether more numbers are right, and none is no longer."""
    if any(len(old) != len(new) for old, new in zip(before, after, strict=True)):
        return all(new.all() or not old.any() for old, new in zip(before, after, strict=True)) and any(
            new.all() and not old.all() for old, new in zip(before, after, strict=True)
        )
    return all(bool((new >= old).all()) for old, new in zip(before, after, strict=True)) and any(
        bool(new.sum() > old.sum()) for old, new in zip(before, after, strict=True)
    )


def gain(before: Sequence[NDArray[np.bool_]], after: Sequence[NDArray[np.bool_]]) -> float:
    """Return how many answers are mended; the part of the numbers where one is mended in part."""
    return sum(float(new.mean()) - float(old.mean()) for old, new in zip(before, after, strict=True))
