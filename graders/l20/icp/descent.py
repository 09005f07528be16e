"""What ICP does, iteration after iteration: the one path that every honest program follows where nothing is tied.

Fitting P anew or composing an increment gives the same R and t, since the best motion for given pairs is unique. The
errors are read on a staircase: the sum of squares when the pairs are chosen, when the cloud has moved, and so on.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from graders.core.contract.values import Floats
from reference.registration import kabsch

#: Two points of Q as near as that to one of P would be a tie; a rotation that poorly held would be anybody's.
APART = 1e-6
#: While it goes down, each iteration takes that share of the error, and that much: who stops early does not stop there.
SHARE, DROP = 0.01, 0.01
DEFAULT = 30
#: Iterations that are followed at most.
LONGEST = 100


class Registration(NamedTuple):
    """The arguments of `icp`: clouds (n, 2) and (m, 2), a start; `n_iter` None where the default is meant."""

    P: Floats
    Q: Floats
    R0: Floats
    t0: Floats
    n_iter: int | None = DEFAULT

    @property
    def iterations(self) -> int:
        return DEFAULT if self.n_iter is None else self.n_iter

    @property
    def arguments(self) -> tuple[object, ...]:
        """As they are given, by position."""
        return tuple(self) if self.n_iter is not None else tuple(self)[:-1]


@dataclass(frozen=True, eq=False)
class Step:
    """One iteration: the rows of Q paired with P, the sum of squares before the move and after it, where P then is.

    `mirrored`: the best orthogonal matrix was no rotation. `sure`: no tie, and one best rotation.
    """

    pairs: np.ndarray
    before: float
    after: float
    R: Floats
    t: Floats
    mirrored: bool
    sure: bool


def descend(P: Floats, Q: Floats, R0: Floats, t0: Floats, n_iter: int) -> Sequence[Step]:
    """The iterations, until the pairs repeat themselves: nothing moves from then on."""
    clouds = [np.ascontiguousarray(one, dtype=np.float64).tobytes() for one in (P, Q, R0, t0)]
    return _whole_way(*clouds)[:n_iter]


@lru_cache(maxsize=512)
def _whole_way(P: bytes, Q: bytes, R0: bytes, t0: bytes) -> Sequence[Step]:
    """Kept: a diagnosis asks the same of every misconception in turn."""
    p, q = (np.frombuffer(cloud).reshape(-1, 2) for cloud in (P, Q))
    return tuple(_steps(p, q, np.frombuffer(R0).reshape(2, 2), np.frombuffer(t0), LONGEST))


def _steps(P: Floats, Q: Floats, R0: Floats, t0: Floats, n_iter: int) -> list[Step]:
    steps: list[Step] = []
    R, t = np.asarray(R0, dtype=np.float64), np.asarray(t0, dtype=np.float64)
    for _ in range(n_iter):
        squares = np.sum((P @ R.T + t - Q[:, None]) ** 2, axis=2)
        pairs = np.argmin(squares, axis=0)
        if steps and np.array_equal(pairs, steps[-1].pairs):
            break
        ranked = np.sqrt(np.sort(squares, axis=0))
        best = kabsch(P, Q[pairs])
        H = (P - P.mean(axis=0)).T @ (Q[pairs] - Q[pairs].mean(axis=0))
        R, t = best.R_q_p, best.t_q_p
        sure = best.unique and (len(Q) < 2 or bool(np.min(ranked[1] - ranked[0]) > APART))
        sums = float(squares.min(axis=0).sum()), best.residual
        steps.append(Step(pairs, *sums, R, t, bool(np.linalg.det(H) < 0.0), sure))
    return steps


def settled(case: Registration, steps: Sequence[Step]) -> bool:
    """Have the pairs repeated themselves before the last iteration?"""
    return len(steps) < case.iterations


def fair(case: Registration) -> bool:
    """Does every honest program end at the same place, even if it stops where the error hardly falls any more?"""
    steps = descend(*case[:4], case.iterations)
    if not all(step.sure for step in steps):
        return False
    costs = [step.before for step in steps] + [steps[-1].after]
    falls = all(last - new > max(DROP, SHARE * last) for last, new in itertools.pairwise(costs))
    return falls and (settled(case, steps) or case.iterations <= 3)


def staircase(steps: Sequence[Step]) -> Floats:
    """All the sums of squares that may be told, in order."""
    return np.array([cost for step in steps for cost in (step.before, step.after)])
