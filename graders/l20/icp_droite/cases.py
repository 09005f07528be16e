"""What submissions are graded on: walls, paired clouds, and matrices some directions of which are not held.

No eigenvalue comes between 0.7 and 1.4 times its threshold.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Arguments, Floats
from graders.l19.matrices import matrix
from reference.registration.observability import line_jacobians

THRESHOLD = 0.01
#: Seed of the cases that never change.
TELLING = 53


def right_normals(Q: Floats) -> Floats:
    chords = np.vstack([Q[1:], Q[-1:]]) - np.vstack([Q[:1], Q[:-1]])
    across = np.column_stack([-chords[:, 1], chords[:, 0]])
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))


def right_system(P: Floats, Q: Floats, N: Floats) -> tuple[Floats, Floats]:
    J = line_jacobians(P, N, P.mean(axis=0))
    gaps = np.sum(N * (P - Q), axis=1)
    return J.T @ J / len(P), J.T @ gaps / len(P)


def right_free(A: Floats, threshold: float = THRESHOLD) -> Floats:
    strengths, axes = np.linalg.eigh(A)
    return np.asarray(axes[:, strengths < threshold].T)


def right_step(A: Floats, g: Floats, threshold: float = THRESHOLD) -> Floats:
    strengths, axes = np.linalg.eigh(A)
    held = axes[:, strengths >= threshold]
    return np.asarray(-held @ ((held.T @ g) / strengths[strengths >= threshold]))


def walls_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Along an axis, slanted, with a corner, with steps of unequal lengths."""
    yield (matrix((0, 0), (1, 0), (2, 0)),)
    yield (matrix((1, 0), (1, 1), (1, 2), (1, 4)),)
    yield (matrix((0, 0), (3, 4), (6, 8)),)
    yield (matrix((0, 0), (1, 0), (2, 0), (2, 1), (2, 2)),)
    yield (matrix((0, 0), (1, 0), (2, 1)),)
    # Points a centimetre apart; a contour whose end comes back near its beginning.
    yield (matrix((0, 0), (0.01, 0), (0.02, 0.01), (0.03, 0.03)),)
    yield (matrix((0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1), (0.1, 0.2)),)


def any_walls(rng: np.random.Generator) -> Iterator[Arguments]:
    yield (matrix((3, 1), (2.4, 1.7), (1.1, 2.2), (-0.3, 2.1), (-0.9, 3.5)),)
    for n in (4, 7, 10):
        turns = np.cumsum(rng.uniform(-0.5, 0.5, n)) + rng.uniform(-3, 3)
        steps = rng.uniform(0.2, 0.8, (n, 1)) * np.column_stack([np.cos(turns), np.sin(turns)])
        yield (np.round(rng.uniform(-3, 3, 2) + np.cumsum(steps, axis=0), 2),)


def is_wall(args: Arguments) -> bool:
    """Has it three points, and is no chord short?"""
    Q = args[0]
    chords = np.vstack([Q[1:], Q[-1:]]) - np.vstack([Q[:1], Q[:-1]])
    return len(Q) >= 3 and float(np.linalg.norm(chords, axis=1).min()) > 0.005


def pairs_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """One point pushed across, then along; a corridor; a corner whose cloud is turned; normals of either sign."""
    up, right = (0.0, 1.0), (1.0, 0.0)
    yield matrix((0, 1), (2, 1)), matrix((0, 0), (2, 0)), matrix(up, up)
    yield matrix((1, 0), (3, 0)), matrix((0, 0), (2, 0)), matrix(up, up)
    hall = matrix((-1, 1), (0, 1), (1, 1), (-1, -1), (0, -1), (1, -1))
    yield hall + matrix((0.5, 0.1)), hall, np.tile(up, (6, 1))
    yield (
        matrix((1, 1), (2, 1), (0, 2), (0, 3)),
        matrix((1, 0), (2, 0.5), (-1, 2), (0.5, 3)),
        matrix(up, up, right, right),
    )
    yield matrix((4, 2), (6, 2), (5, 4)), matrix((4, 1), (6, 3), (5, 4)), matrix(up, (0, -1), (0.6, 0.8))


def any_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    for source in (np.random.default_rng(TELLING), rng, rng, rng):
        yield drawn_pairs(source)


def drawn_pairs(rng: np.random.Generator) -> Arguments:
    """A cloud away from the origin, gaps of some decimetres, normals any."""
    n = int(rng.integers(4, 9))
    P = np.round(rng.uniform(1, 4, 2) + rng.uniform(-2, 2, (n, 2)), 2)
    Q = np.round(P + rng.uniform(-0.4, 0.4, (n, 2)), 2)
    angles = rng.uniform(-3, 3, n)
    return P, Q, np.column_stack([np.cos(angles), np.sin(angles)])


def matrices_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """The corridor of the statement, a slanted one, a round room, a square one, one short wall, one hardly slanted."""
    yield (np.diag([0.0, 1.0, 2.0 / 3.0]),)
    yield (np.diag([0.5, 0.5, 1.0]),)
    yield (np.diag([0.5, 0.5, 0.0]),)
    yield (np.diag([0.0, 1.0, 0.001]),)
    yield (matrix((0.36, -0.48, 0), (-0.48, 0.64, 0), (0, 0, 1)),)
    yield (np.diag([0.006, 0.994, 0.7]),)
    yield (np.diag([0.015, 0.985, 0.7]),)


def any_matrices(rng: np.random.Generator) -> Iterator[Arguments]:
    for source in (np.random.default_rng(TELLING), rng, rng):
        for strengths in ((0.0, 0.5, 1.2), (0.002, 0.03, 0.8), (0.001, 0.003, 0.9), (0.05, 3.0, 9.0)):
            yield (drawn_matrix(source, strengths),)


#: Strengths and a threshold: it makes free what the usual one holds, or the other way.
ASKED = (
    ((0.002, 0.03, 0.8), 0.1),
    ((0.002, 0.03, 0.8), 0.0005),
    ((0.05, 0.4, 0.9), 0.15),
    ((0.0001, 0.004, 0.7), 0.001),
)


def matrices_at_a_threshold(rng: np.random.Generator) -> Iterator[Arguments]:
    for source in (np.random.default_rng(TELLING), rng):
        for strengths, threshold in ASKED:
            yield drawn_matrix(source, strengths), threshold
    A = drawn_matrix(np.random.default_rng(TELLING), (0.002, 0.03, 0.8))
    yield from ((A, threshold) for threshold in (0.1, 0.0005))
    yield drawn_matrix(np.random.default_rng(TELLING), (0.9, 1.5, 4.5)), 2.5


def drawn_matrix(rng: np.random.Generator, strengths: tuple[float, float, float]) -> Floats:
    """Symmetric, with these eigenvalues and any axes, none of which is near a coordinate axis."""
    while True:
        axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        if float(np.abs(axes).min()) > 0.15:
            break
    A = (axes * strengths) @ axes.T
    return np.asarray((A + A.T) / 2.0)


def with_gradient(rng: np.random.Generator, args: Arguments) -> Arguments:
    """The matrix, a right-hand side to one decimal, the threshold if there is one."""
    signs = rng.choice([-1.0, 1.0], 3)
    return args[0], np.round(signs * rng.uniform(0.1, 0.6, 3), 1), *args[1:]


def steps_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    yield np.diag([0.0, 1.0, 2.0 / 3.0]), np.array([0.0, 0.1, 0.0])
    source = np.random.default_rng(TELLING)
    for args in matrices_by_hand(rng):
        yield with_gradient(source, args)


def any_steps(rng: np.random.Generator) -> Iterator[Arguments]:
    for args in any_matrices(rng):
        yield with_gradient(rng, args)


def steps_at_a_threshold(rng: np.random.Generator) -> Iterator[Arguments]:
    for args in matrices_at_a_threshold(rng):
        yield with_gradient(rng, args)


def is_clear(args: Arguments) -> bool:
    """Is no eigenvalue between 0.7 and 1.4 times the threshold, and none negative?"""
    threshold = args[-1] if isinstance(args[-1], float) else THRESHOLD
    if not np.array_equal(args[0], args[0].T):
        return False
    strengths = np.linalg.eigvalsh(args[0])
    near = (strengths > 0.7 * threshold) & (strengths < 1.4 * threshold)
    return bool(strengths[0] > -1e-12 and strengths[-1] > 0.1 and not np.any(near) and threshold > 1e-5)


def have_unit_normals(args: Arguments) -> bool:
    return bool(np.allclose(np.linalg.norm(args[2], axis=1), 1.0, atol=1e-12))
