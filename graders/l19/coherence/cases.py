"""The errors that submissions are graded on: a few numbers by hand, then runs made to have a mean NEES of our choice.

No mean comes within MARGIN of an end of its band, so that how a quantile is computed decides nothing. By hand, some
fall between the band and those of the usual mistakes: one-sided, other degrees of freedom, a normal law.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from graders.core.contract.values import Arguments
from graders.l19.coherence.truth import right_band, right_verdict
from graders.l19.matrices import drawn_covariance, is_covariance, matrix, vector

#: Of the end of a band.
MARGIN = 0.01
#: Numbers from which an array is told by its shape in a sentence, instead of being written out.
FEWEST = 41
#: Seed of the runs that never change.
TELLING = 19


def errors_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """One number, two, an error along and one across the doubt, three numbers."""
    yield vector(3), vector(1), matrix((4,))
    yield vector(2, 1), vector(0, 2), matrix((4, 0), (0, 0.25))
    yield vector(3, 4), vector(1, 1), matrix((2, 1), (1, 2))
    yield vector(1, -2), vector(2, -4), matrix((1, -0.5), (-0.5, 3))
    yield vector(1, 0, 2), vector(0, 2, -1), matrix((2, 0.5, 0), (0.5, 1, 0.25), (0, 0.25, 3))


def any_errors(rng: np.random.Generator) -> Iterator[Arguments]:
    yield vector(0.4, -1.3), vector(1.1, 0.2), matrix((0.6, 0.2), (0.2, 1.5))
    for n in (1, 2, 3, 4):
        estimated = np.round(rng.uniform(-5.0, 5.0, n), 2)
        yield estimated + np.round(rng.uniform(0.2, 2.0, n) * rng.choice([-1.0, 1.0], n), 2), estimated, \
            drawn_covariance(rng, n)  # fmt: skip


def bands(rng: np.random.Generator) -> Iterator[Arguments]:
    """Of other levels than the usual one."""
    yield 1, 1, 0.9
    yield 2, 10, 0.99
    yield 3, 50, 0.8
    yield 4, 1, 0.5
    yield 2, 10, 0.999
    yield 1, 6, 0.05
    yield int(rng.integers(1, 5)), int(rng.integers(5, 80)), float(np.round(rng.uniform(0.6, 0.99), 2))


def usual_bands(rng: np.random.Generator) -> Iterator[Arguments]:
    yield 2, 10
    yield 1, 25
    yield int(rng.integers(1, 5)), int(rng.integers(20, 100))


def runs_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Four runs of one number, three times with the same errors: coherent, too sure, too careful. Then two numbers."""
    true, estimated = matrix((2,), (0,), (3,), (1,)), matrix((1,), (1,), (1,), (1,))
    for variance in (1.0, 0.25, 25.0):
        yield true, estimated, np.full((4, 1, 1), variance)
    yield (
        matrix((1, 2), (0, 1), (3, -1)),
        matrix((0, 0), (1, 1), (2, 1)),
        np.array([[[2.0, 0.5], [0.5, 1.0]], [[1.0, 0.0], [0.0, 4.0]], [[0.5, 0.1], [0.1, 2.0]]]),
    )
    yield matrix((4, 0), (0, 5), (3, -2)), matrix((0, 0), (1, 1), (2, 1)), np.array([0.5 * np.eye(2)] * 3)
    # One run alone, which the band judges too; then forty, between the ends of the band and those of the normal law.
    yield matrix((4,)), matrix((1,)), np.array([[[1.0]]])
    yield matrix((1.01,)), matrix((1,)), np.array([[[1.0]]])
    alternating = np.resize((1.0, -1.0), (40, 1))
    for mean in (1.46, 0.585):
        yield np.round(mean**0.5 * alternating, 6), np.zeros((40, 1)), np.ones((40, 1, 1))
    # A hundred, of which the last ones make the filter too sure of itself.
    grown = np.resize((1.0, -1.0), (100, 1)) * np.where(np.arange(100) < 60, 1.0, 2.0)[:, None]
    yield grown, np.zeros((100, 1)), np.ones((100, 1, 1))


def telling_runs(rng: np.random.Generator) -> Iterator[Arguments]:
    """Means just inside and just outside of the band, on either side, where the usual mistakes judge otherwise."""
    yield from _always()


@lru_cache(maxsize=1)
def _always() -> tuple[Arguments, ...]:
    rng = np.random.default_rng(TELLING)
    asked = ((1, 45, 0.93), (2, 24, 0.03), (2, 30, 1.06), (3, 16, -0.06), (3, 20, 0.5), (2, 25, 1.3))
    return tuple(drawn_runs(rng, n, N, where) for n, N, where in asked)


def any_runs(rng: np.random.Generator) -> Iterator[Arguments]:
    yield from telling_runs(rng)
    for where in (1.5, -0.4, float(rng.uniform(0.15, 0.85))):
        n = int(rng.integers(1, 4))
        yield drawn_runs(rng, n, FEWEST // n + int(rng.integers(1, 9)), where)


def drawn_runs(rng: np.random.Generator, n: int, N: int, where: float) -> Arguments:
    """N runs of which the mean NEES falls at `where` in the band: 0 at its low end, 1 at its high end."""
    low, high = right_band(n, N)
    covariances = np.array([drawn_covariance(rng, n) for _ in range(N)])
    white = rng.normal(size=(N, n))
    white *= np.sqrt(max(low + where * (high - low), 0.3 * low) / np.mean(np.sum(white**2, axis=1)))
    estimated = np.round(rng.uniform(-5.0, 5.0, (N, n)), 2)
    errors = np.array([np.linalg.cholesky(P) @ one for P, one in zip(covariances, white, strict=True)])
    return np.round(estimated + errors, 4), estimated, covariances


def decides(args: Arguments) -> bool:
    """Is the mean clear of both ends of its band?"""
    true = args[0]
    mean, _ = right_verdict(*args)
    return all(abs(mean - end) > MARGIN * end for end in right_band(true.shape[1], len(true)))


def is_error(args: Arguments) -> bool:
    """Is it an error that the statement allows, and that is none in no component?"""
    true, estimated, P = args
    return bool(np.all(true != estimated)) and is_covariance(P)


def is_band(args: Arguments) -> bool:
    """Is it a band that the statement allows, of a law that can be drawn?"""
    n, N = args[:2]
    level = args[2] if len(args) > 2 else 0.5
    return bool(n <= 4 <= n * N and 0.4 < level < 0.995)
