"""The filters that submissions are graded on: small whole numbers by hand first, then matrices of all shapes.

By hand no F is symmetric, no P is diagonal where that would hide an order or a transposition, and H is not square.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Arguments
from graders.l19.matrices import drawn_covariance, drawn_matrix, is_covariance, matrix, vector


def steps_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Position and speed, a quarter of turn, one number alone, then no noise at all."""
    yield vector(2, 1), matrix((1, 0), (0, 4)), matrix((1, 1), (0, 1)), matrix((0.5, 0), (0, 0.25))
    yield vector(1, -2), matrix((4, 1), (1, 2)), matrix((0, -1), (1, 0)), matrix((1, 0.5), (0.5, 3))
    yield vector(3), matrix((2,)), matrix((0.5,)), matrix((1,))
    yield vector(1, 2), matrix((3, -1), (-1, 2)), matrix((2, 1), (0, 1)), matrix((0, 0), (0, 0))


def any_steps(rng: np.random.Generator) -> Iterator[Arguments]:
    yield (
        vector(0.5, -1.25, 2),
        matrix((2, 0.5, -0.3), (0.5, 1, 0.2), (-0.3, 0.2, 3)),
        matrix((1, 0.5, 0.125), (0, 1, 0.5), (0, 0, 1)),
        matrix((0.1, 0.05, 0), (0.05, 0.2, 0.1), (0, 0.1, 0.4)),
    )
    for n in (2, 3, 4, 2):
        yield (
            np.round(rng.uniform(-5.0, 5.0, n), 2) + 0.0,
            drawn_covariance(rng, n),
            drawn_matrix(rng, n, n),
            drawn_covariance(rng, n, 0.3),
        )


def readings_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """The position alone, a difference, two numbers seen of two, of three, more numbers seen than there are."""
    yield vector(2, 1), matrix((4, 2), (2, 3)), vector(4), matrix((1, 0)), matrix((1,))
    yield vector(1, 2), matrix((2, 0), (0, 1)), vector(3), matrix((1, -1)), matrix((3,))
    yield vector(0, 1), matrix((2, 1), (1, 3)), vector(2, 0), matrix((1, 2), (0, 1)), matrix((2, 1), (1, 4))
    yield (
        vector(1, 0, 2),
        matrix((2, 1, 0), (1, 2, 0), (0, 0, 4)),
        vector(0, 3),
        matrix((1, 0, 1), (0, 2, 0)),
        matrix((1, 0.5), (0.5, 2)),
    )
    yield vector(2), matrix((3,)), vector(1, 4), matrix((1,), (2,)), matrix((1, 0), (0, 2))
    # Two correlated numbers seen of one; three of three, and of four; a sensor far better than another one.
    yield vector(2), matrix((3,)), vector(1, 4), matrix((1,), (2,)), matrix((1, 0.75), (0.75, 2))
    three = matrix((2, 0.5, 0), (0.5, 1, 0.25), (0, 0.25, 3))
    yield vector(1, -2, 3), matrix((2, 1, 0), (1, 3, 1), (0, 1, 4)), vector(2, 0, 5), \
        matrix((1, 1, 0), (0, 2, -1), (1, 0, 1)), three  # fmt: skip
    yield vector(1, -2, 3, 0.5), np.diag([2.0, 3.0, 4.0, 1.0]) + 0.5, vector(2, 0, 5), \
        matrix((1, 1, 0, 2), (0, 2, -1, 0), (1, 0, 1, -1)), three  # fmt: skip
    yield vector(1, 2), matrix((2, 1), (1, 3)), vector(4, 1), matrix((1, 1), (0, 1)), matrix((0.06, 0), (0, 900))


def any_readings(rng: np.random.Generator) -> Iterator[Arguments]:
    yield (
        vector(0.5, -1.5, 2.25),
        matrix((2, 0.5, -0.25), (0.5, 1, 0.25), (-0.25, 0.25, 3)),
        vector(1.5),
        matrix((0.5, -1, 2)),
        matrix((0.25,)),
    )
    for n, m in ((2, 1), (4, 2), (2, 2), (3, 2), (2, 3)):
        yield (
            np.round(rng.uniform(-5.0, 5.0, n), 2) + 0.0,
            drawn_covariance(rng, n),
            np.round(rng.uniform(-5.0, 5.0, m), 2) + 0.0,
            drawn_matrix(rng, m, n),
            drawn_covariance(rng, m, 0.5),
        )


def is_step(args: Arguments) -> bool:
    """Is it a step that the statement allows, from a state that is not zero, and that loses none of it?"""
    x, P, F, Q = args
    telling = np.any(x) and abs(np.linalg.det(F)) > 0.1
    return bool(telling) and is_covariance(P) and is_covariance(Q, least=-1e-12)


def is_reading(args: Arguments) -> bool:
    """Is it a reading that the statement allows, that sees something and says something new?"""
    x, P, z, H, R = args
    return is_covariance(P) and is_covariance(R) and bool(np.all(np.any(H, axis=1)) and np.any(z - H @ x))
