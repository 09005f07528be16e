"""The clouds of l20/icp: one iteration or two, then many, from starts that matter, clouds of unequal sizes, mirrors."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.icp.descent import DEFAULT, Registration, Step, descend, fair
from reference.se2 import rotation_matrix

Rng = np.random.Generator
Draw = Callable[[Rng], Iterator[Registration]]

FEWEST, MOST = 3, 22
#: Between the first iteration and the last: what who stops after one is told apart by.
FAR = 0.05
NOWHERE = np.zeros(2)
STILL = np.eye(2)


def example(n_iter: int) -> Registration:
    """Four points, moved by two cells: half the pairs are wrong at first."""
    P = np.array([[0.0, 0.0], [3.0, 0.0], [5.0, 0.0], [5.0, 4.0]])
    return Registration(P, P + np.array([2.0, 1.0]), STILL, NOWHERE, n_iter)


def cloud(rng: Rng, n: int) -> Floats:
    """n points to one decimal, none on another, along two sides of a room and beside."""
    points = np.array([[rng.uniform(0, 9), rng.normal(0, 0.2)] for _ in range(n // 2)]
                      + [[rng.normal(9, 0.3), rng.uniform(0, 6)] for _ in range(n - n // 2)])  # fmt: skip
    return np.round(points, 1) + 0.0


@dataclass(frozen=True)
class Kind:
    """How clouds are made: n points, Q with `more` of them or `fewer`; `least` iterations are needed at least.

    `seeds` are those whose clouds are `telling`: looking for some takes too long for a verdict, and a test tries them.
    The first one is always asked: a mistake that shows on any other shows on it, or on another that is always asked.
    """

    seeds: tuple[int, ...]
    n: int = 7
    more: int = 0
    fewer: int = 0
    noise: float = 0.0
    mirror: bool = False
    start: bool = False
    n_iter: int | None = DEFAULT
    least: int = FEWEST

    def made(self, seed: int) -> Registration:
        """A cloud and its image, shuffled; a start, or none."""
        rng = np.random.default_rng(seed)
        P = cloud(rng, self.n)
        turn = rotation_matrix(float(rng.uniform(0.15, 0.7) * rng.choice([-1.0, 1.0])))
        image = (P * (-1.0, 1.0) if self.mirror else P) @ turn.T + rng.uniform(-2.0, 2.0, 2)
        extra = rng.uniform(-2.0, 10.0, (self.more, 2))
        Q = np.vstack([image + self.noise * rng.normal(size=P.shape), extra])[self.fewer :]
        Q = np.round(Q[rng.permutation(len(Q))], 1) + 0.0
        R0, t0 = STILL, NOWHERE
        if self.start:
            R0 = turn @ rotation_matrix(float(rng.uniform(0.2, 0.5) * rng.choice([-1.0, 1.0])))
            t0 = np.round(rng.uniform(-3.0, 3.0, 2), 1)
        return Registration(P, Q, R0, t0, self.n_iter)

    def telling(self, seed: int) -> bool:
        """Does every honest program end at one place, far from where mistakes lead?"""
        case = self.made(seed)
        steps = descend(*case[:4], DEFAULT)
        if not self.least <= len(steps) <= MOST or not fair(case):
            return False
        if self.mirror and not any(step.mirrored for step in steps[: case.iterations]):
            return False
        return apart(steps[0], steps[-1]) and (not self.start or the_start_matters(case))

    def some(self, rng: Rng, drawn: int = 1) -> Iterator[Registration]:
        """The first one, whatever is drawn, then others."""
        yield self.made(self.seeds[0])
        for seed in rng.choice(self.seeds[1:], drawn, replace=False):
            yield self.made(int(seed))


def apart(one: Step, other: Step) -> bool:
    return bool(np.max(np.abs(one.R - other.R)) + np.max(np.abs(one.t - other.t)) > FAR)


def the_start_matters(case: Registration) -> bool:
    """Do who forgets R0, or t0, or takes R0 for its transpose, end elsewhere?"""
    P, Q, R0, t0, _ = case
    last = descend(P, Q, R0, t0, case.iterations)[-1]
    others = ((STILL, NOWHERE), (R0, NOWHERE), (STILL, t0), (R0.T, t0))
    return all(apart(descend(P, Q, R, t, case.iterations)[-1], last) for R, t in others)


ONE = Kind((10, 2, 6, 7, 8, 11, 12, 13, 15), n=5, n_iter=1)
TWO = Kind((8, 2, 6, 7, 11, 12, 13, 15, 17), n=5, n_iter=2)
ONE_FROM = Kind((0, 3, 4, 6, 9, 10, 12, 13, 15), n=6, n_iter=1, start=True)
THREE_FROM = Kind((18, 10, 0, 9, 28, 30, 32, 35, 36), n=6, n_iter=3, start=True, more=2, least=4)
SAME = Kind((4, 0, 1, 2, 7, 9, 11, 16, 17), n=6)
LARGER = Kind((4, 0, 3, 10, 11, 12, 14, 15, 16), n=8, least=4)
FROM = Kind((6, 3, 47, 68, 101, 121, 183, 211), n=6, start=True)
NOISY_FROM = Kind((33, 6, 32, 85, 105, 117, 123), n=8, start=True, noise=0.05)
MORE = Kind((4, 0, 2, 7, 8, 9, 14, 18, 19), n=6, more=3)
FEWER = Kind((9, 10, 12, 14, 16, 17, 19, 20, 22), n=8, fewer=3)
NOISY = Kind((9, 0, 1, 2, 6, 10, 11, 12, 14), n=7, more=2, noise=0.1)
MIRROR = Kind((186, 42, 148, 152, 236, 317, 475), n=5, mirror=True)
MIRROR_TWO = Kind((11, 49, 175, 319, 322, 383, 425, 498, 559), n=6, mirror=True, n_iter=2)
LONGEST = 87
#: Of LARGER: an iteration lowers E by less than a twentieth; E is below a tenth. Then the pairs still change.
SLOW = (123, 51)
MANY = Kind((328, LONGEST, 23, 115, 159, 165, 234, 337), n=12, n_iter=None, least=11)
SHORT = Kind((0, 3, 4, 10, 11, 12, 14, 16, 17), n=8, n_iter=2, noise=0.1, least=4)


def one_iteration(rng: Rng) -> Iterator[Registration]:
    """One iteration, from nowhere."""
    yield example(1)
    yield from ONE.some(rng)


def few_iterations(rng: Rng) -> Iterator[Registration]:
    """Two iterations from nowhere, then one or three from a start."""
    yield example(2)
    for kind in (TWO, ONE_FROM, THREE_FROM):
        yield from kind.some(rng)


def to_the_end(rng: Rng) -> Iterator[Registration]:
    """The same points in another order, from no start, as many iterations as it takes."""
    yield example(DEFAULT)
    yield from SAME.some(rng, 2)
    yield from LARGER.some(rng, 2)
    yield from (LARGER.made(seed) for seed in SLOW)


def from_a_start(rng: Rng) -> Iterator[Registration]:
    """Starts without which the clouds end elsewhere."""
    yield from FROM.some(rng, 2)
    yield from NOISY_FROM.some(rng, 2)


def of_unequal_sizes(rng: Rng) -> Iterator[Registration]:
    """More points in Q, then fewer, with noise."""
    yield from MORE.some(rng, 2)
    yield from FEWER.some(rng, 2)
    yield from NOISY.some(rng, 2)


def mirrored(rng: Rng) -> Iterator[Registration]:
    """The best matrix of some iteration is a reflection."""
    yield from MIRROR.some(rng, 2)
    yield from MIRROR_TWO.some(rng, 2)


def without_count(rng: Rng) -> Iterator[Registration]:
    """The number of iterations is not given, and many are needed: fourteen at first."""
    yield MANY.made(LONGEST)
    yield from MANY.some(rng, 1)


def for_errors(rng: Rng) -> Iterator[Registration]:
    """Where errors are looked at: to zero, then to what noise leaves, then cut short."""
    yield example(DEFAULT)
    for kind in (SAME, NOISY, ONE_FROM, SHORT):
        yield from kind.some(rng)
