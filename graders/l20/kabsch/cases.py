"""The clouds that submissions are graded on, from whole numbers and quarter turns to noise, mirrors and lines.

Wherever an answer serves the diagnosis, H has well separated singular values, so that every style of the same mistake
gives the same numbers, and n differs from d, so that a cloud read the wrong way round shows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import islice

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.kabsch.best import best_of
from graders.l20.kabsch.checks import Pairing
from reference.se2 import rotation_matrix

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])
ABOUT_Z = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
AXES_IN_TURN = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""x to y, y to z, z to x: a third of a turn about (1, 1, 1)."""

GAP = 0.15
#: Seed of what never changes: what is caught does not depend on that of the grading.
TELLING = 3
SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
OCTAHEDRON = np.vstack([2.0 * np.eye(3), -2.0 * np.eye(3)])


def points(*rows: Sequence[float]) -> Floats:
    return np.array(rows, dtype=np.float64)


def moved(P: Floats, R: Floats, t: Sequence[float] | Floats) -> Pairing:
    """P and its exact image; adding 0.0 rids it of negative zeros."""
    return Pairing(P, P @ R.T + np.asarray(t) + 0.0)


def well_separated(pairing: Pairing) -> bool:
    """Do the singular values of H differ from one another, and from zero, by a fair part of the largest?"""
    values = np.append(best_of(pairing.P, pairing.Q).singular_values, 0.0)
    return bool(np.min(-np.diff(values)) > GAP * values[0] / len(values))


def examples(rng: np.random.Generator) -> Iterator[Pairing]:
    """The course's example, then whole numbers and quarter turns of the plane."""
    yield Pairing(points((0, 0), (1, 0), (0, 1)), points((1, 1), (1, 2), (0, 1)))
    yield moved(points((0, 0), (2, 0), (0, 1)), np.eye(2), (3, 1))
    yield moved(points((1, 0), (3, 0), (1, 1)), -np.eye(2), (0, 1))
    yield moved(points((0, 0), (3, 1), (1, 2)), QUARTER.T, (1, 0))
    for _ in range(2):
        yield _whole_numbers(rng)


def _whole_numbers(rng: np.random.Generator) -> Pairing:
    turn = np.linalg.matrix_power(QUARTER, int(rng.integers(1, 4)))
    while True:
        pairing = moved(rng.integers(-4, 5, (4, 2)).astype(float), turn, rng.integers(-3, 4, 2).astype(float))
        # The first three make a triangle: whoever looks at these alone is right here, whatever is drawn.
        if well_separated(pairing) and abs(np.linalg.det(pairing.P[1:3] - pairing.P[0])) > 0.5:
            return pairing


def random_rotation(rng: np.random.Generator, d: int) -> Floats:
    """A rotation far enough from the identity and from its own inverse for a mistake to show."""
    angle = rng.uniform(0.4, 2.7) * rng.choice([-1.0, 1.0])
    if d == 2:
        return rotation_matrix(angle)
    x, y, z = axis = rng.normal(size=3)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) / np.linalg.norm(axis)
    return np.asarray(np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * (K @ K))


def random_cloud(rng: np.random.Generator, n: int, d: int) -> Floats:
    """n points spread unequally along oblique axes, around a centre away from the origin, to one decimal."""
    cloud: Floats = (rng.normal(size=(n, d)) * (3.0, 1.8, 0.9)[:d]) @ random_rotation(rng, d).T
    cloud += rng.uniform(1.0, 5.0, d) * rng.choice([-1.0, 1.0], d)
    return np.round(cloud, 1) + 0.0


def random_pairing(rng: np.random.Generator, d: int, *, noise: float = 0.0, mirror: bool = False) -> Pairing:
    """A random cloud and its image, to one decimal where it is noisy anyway."""
    while True:
        P = random_cloud(rng, int(rng.integers(d + 3, d + 7)), d)
        flip = np.diag([-1.0] + [1.0] * (d - 1)) if mirror else np.eye(d)
        P, Q, _ = moved(P, random_rotation(rng, d) @ flip, rng.uniform(-5.0, 5.0, d))
        pairing = Pairing(P, np.round(Q + noise * rng.normal(size=Q.shape), 1) + 0.0 if noise else Q)
        if well_separated(pairing):
            return pairing


def exact_2d(rng: np.random.Generator) -> Iterator[Pairing]:
    """Rotations of any angle: first the right triangle 3-4-5, which keeps whole numbers, then more than a quarter."""
    yield moved(points((0, 0), (5, 0), (0, 10)), points((0.6, -0.8), (0.8, 0.6)), (1, 2))
    yield moved(points((0, 0), (5, 0), (0, 10)), points((-0.8, -0.6), (0.6, -0.8)), (2, 1))
    for _ in range(3):
        yield random_pairing(rng, 2)


def exact_3d(rng: np.random.Generator) -> Iterator[Pairing]:
    corner = points((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3))
    yield moved(corner, ABOUT_Z, (0, 0, 1))
    yield moved(corner + 1.0, AXES_IN_TURN, (1, 0, -2))
    for _ in range(3):
        yield random_pairing(rng, 3)


def noisy(rng: np.random.Generator) -> Iterator[Pairing]:
    """Clouds that no rigid motion makes coincide: first a rectangle that comes back turned and stretched."""
    rectangle = points((0, 0), (2, 0), (2, 1), (0, 1))
    yield moved(rectangle * (2.0, 1.0), QUARTER, (1, 0))._replace(P=rectangle)
    yield moved(rectangle * (10.0, 5.0), points((-0.8, 0.6), (-0.6, -0.8)), (1, 0))._replace(P=rectangle * 5.0)
    for d in (2, 3, 3):
        yield random_pairing(rng, d, noise=0.3)


def translated(rng: np.random.Generator) -> Iterator[Pairing]:
    """Pairings of all kinds: exact, noisy, mirrored, in the plane and in space."""
    yield from islice(examples(rng), 4)
    yield from islice(exact_3d(rng), 1, 2)
    yield from islice(noisy(rng), 2)
    yield random_pairing(rng, 3, noise=0.3)
    for d in (2, 3):
        yield _always_mirrored(d)[0]


def mirrored_2d(rng: np.random.Generator) -> Iterator[Pairing]:
    """Those of `mirrored` in the plane, where V and its transpose may be taken for one another: a mend shows alone."""
    return (pairing for pairing in mirrored(rng) if pairing.P.shape[1] == 2)


def mirrored_3d(rng: np.random.Generator) -> Iterator[Pairing]:
    """Those of `mirrored` in space."""
    return (pairing for pairing in mirrored(rng) if pairing.P.shape[1] == 3)


def mirrored(rng: np.random.Generator) -> Iterator[Pairing]:
    """Clouds whose best orthogonal matrix is a reflection, so that the best rotation is another one.

    Two of them serve the diagnosis: whoever makes another mistake too is then still told about that one.
    """
    tall, wide = points((0, 0), (1, 0), (1, 3), (0, 3)), points((0, 0), (3, 0), (3, 1), (0, 1))
    corner = points((0, 0, 0), (3, 0, 0), (0, 2, 0), (0, 0, 1), (1, 1, 1))
    yield Pairing(tall, tall * (-1.0, 1.0) + 0.0, observed=False)
    yield Pairing(wide, wide * (-1.0, 1.0) + 0.0, observed=False)
    yield Pairing(wide, wide[:, ::-1].copy(), observed=False)
    yield Pairing(corner, corner * (-1.0, 1.0, 1.0) + 0.0, observed=False)
    for d in (2, 3):
        yield random_pairing(rng, d, noise=0.1, mirror=True)
        yield from _always_mirrored(d)


def degenerate(rng: np.random.Generator) -> Iterator[Pairing]:
    """Clouds too poor to fix a rotation, and flat ones that fix it all the same; none serves the diagnosis.

    They are the same in every grading: which of two signs a decomposition gives them is up to what is drawn.
    """
    yield from _always_degenerate()


@lru_cache(maxsize=1)
def _always_degenerate() -> tuple[Pairing, ...]:
    rng = np.random.default_rng(TELLING)
    return tuple(Pairing(P, Q, observed=False) for P, Q in (*_poor_clouds(rng), *_flat_clouds(rng)))


@lru_cache(maxsize=2)
def _always_mirrored(d: int) -> tuple[Pairing, ...]:
    rng = np.random.default_rng(TELLING)
    return tuple(random_pairing(rng, d, noise=0.3, mirror=True)._replace(observed=False) for _ in range(2))


def _poor_clouds(rng: np.random.Generator) -> Iterator[tuple[Floats, Floats]]:
    """A single point, points in one place, points in a line of space, and clouds too symmetric for their mirror."""
    x, y = rng.integers(1, 5, 2)
    yield points((2, 1)), points((x + 2, -y))
    yield points(*[(1, 2)] * 3), points(*[(x, -y)] * 3)
    yield points(*[(1, 2, 3)] * 3), points(*[(-x, y, 1)] * 3)
    yield points((0, 0), (2, 0), (0, 1)), points(*[(x, y)] * 3)
    yield points((0, 0, 0), (2, 0, 0)), points((1, 1, 1), (1, 3, 1))
    yield points((0, 0, 0), (1, 2, 2), (3, 6, 6)), points((1, y, 0), (1, y + 3, 0), (1, y + 9, 0))
    yield SQUARE, SQUARE * (-1.0, 1.0)
    yield OCTAHEDRON, points((x, y, 1)) - OCTAHEDRON
    line = rng.uniform(-4.0, 4.0, (5, 1)) * rng.normal(size=3)
    yield line + rng.uniform(-3.0, 3.0, 3), line @ random_rotation(rng, 3).T


def _flat_clouds(rng: np.random.Generator) -> Iterator[tuple[Floats, Floats]]:
    """Two points of the plane, points of a line of the plane or of a plane in space, the same cloud twice."""
    x, y = rng.integers(1, 5, 2)
    yield points((0, 0), (2, 0)), points((x, 1), (x, 3))
    yield points((0, 0), (1, 1)), points((3, 2), (2, 1))
    yield points((1, 2), (2, 4)), points((x, y), (x - 2, y + 1))
    yield points((-1, 2), (2, 1)), points((x, y), (x - 3, y + 1))
    yield points((0, 0), (1, 1), (3, 3)), points((x, y), (x + 1, y - 1), (x + 3, y - 3))
    flat = points((0, 0, 0), (3, 0, 0), (0, 2, 0), (1, 1, 0))
    for R in (ABOUT_Z, AXES_IN_TURN, random_rotation(rng, 3), random_rotation(rng, 3)):
        yield moved(flat, R, (x, -1, y))[:2]
    for d in (2, 3):
        same = random_cloud(rng, 5, d)
        yield same, same.copy()
    for d in (2, 3):  # many points, no two halves of which say the same
        many = random_cloud(rng, 40, d)
        image = moved(many, random_rotation(rng, d), rng.uniform(-5.0, 5.0, d))[1]
        yield many, np.round(image + 0.4 * rng.normal(size=image.shape) * np.linspace(0.0, 2.0, 40)[:, None], 1) + 0.0
