"""Covariances of module L19: how they are drawn at random, and simplified in a counterexample."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.compare.shrinking import reading_cost, shrink_number
from graders.core.contract.values import Floats, Value

#: The smallest eigenvalue of a covariance that is asked to be inverted.
LEAST = 0.05


def matrix(*rows: tuple[float, ...]) -> Floats:
    return np.array(rows, dtype=np.float64)


def vector(*values: float) -> Floats:
    return np.array(values, dtype=np.float64)


def drawn_covariance(rng: np.random.Generator, n: int, scale: float = 1.0) -> Floats:
    """Positive definite, with correlations, to two decimals."""
    while True:
        factor = rng.normal(size=(n, n))
        found: Floats = np.round(scale * (factor @ factor.T + 0.3 * np.eye(n)), 2) + 0.0
        if is_covariance(found):
            return found


def drawn_matrix(rng: np.random.Generator, rows: int, columns: int) -> Floats:
    return np.round(rng.uniform(-2.0, 2.0, (rows, columns)), 1) + 0.0


def is_covariance(found: Floats, *, least: float = LEAST) -> bool:
    """Is it symmetric, with no eigenvalue below `least`?"""
    return bool(np.array_equal(found, found.T) and np.linalg.eigvalsh(found)[0] >= least)


def shrink_covariance(value: Value) -> Iterator[Value]:
    """Rounded, then one entry and its mirror image at a time; what is no covariance is not proposed."""
    given = np.asarray(value, dtype=np.float64)
    for candidate in _simpler(given):
        if is_covariance(candidate):
            yield candidate


def shrink_noise(value: Value) -> Iterator[Value]:
    """The same, of one that may vanish."""
    given = np.asarray(value, dtype=np.float64)
    if np.any(given):
        yield np.zeros_like(given)
    for candidate in _simpler(given):
        if is_covariance(candidate, least=-1e-12):
            yield candidate


def _simpler(given: Floats) -> Iterator[Floats]:
    rounded = np.round(given)
    if np.any(rounded != given):
        yield rounded
    plain = np.diag(np.diag(given))
    if np.any(plain != given):
        yield plain
    for i in range(len(given)):
        for j in range(i + 1):
            for candidate in shrink_number(float(given[i, j])):
                simpler = given.copy()
                simpler[i, j] = simpler[j, i] = candidate
                if reading_cost(candidate) < reading_cost(float(given[i, j])):
                    yield simpler
