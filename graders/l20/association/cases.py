"""Measurements and maps that submissions are graded on: by hand, then drawn so that nothing hangs on a tie.

No distance comes within MARGIN of its threshold. A scan judged as a whole has one best hypothesis, which is the same
whether all are tried or the tree is cut, and which plain nearest neighbours miss in most.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import product

import numpy as np
from scipy.special import gammaincinv

from graders.core.contract.values import Arguments, Floats
from graders.l19.matrices import drawn_covariance, is_covariance, matrix
from reference.data_association import (
    AssociationError,
    ExpectedSightings,
    joint_compatibility,
    joint_distance,
)

#: Of a threshold, and of a distance between two choices.
MARGIN = 0.01
LEVEL = 0.99
NO_ANGLE = (False, False)
#: (measurement, landmark) of each pair of a hypothesis.
Pairs = tuple[tuple[int, int], ...]


def threshold(level: float, pairs: int = 1) -> float:
    return float(2.0 * gammaincinv(float(pairs), level))


def right_distances(z: Floats, landmarks: Floats, S: Floats) -> Floats:
    away = z[:, None, :] - landmarks[None]
    return np.asarray(np.einsum("mki,kij,mkj->mk", away, np.linalg.inv(S), away))


def right_nearest(z: Floats, landmarks: Floats, S: Floats, level: float = LEVEL) -> list[int]:
    """By hand and not by the reference, whose landmarks share one noise."""
    distances = right_distances(z, landmarks, S)
    chosen = [-1] * len(z)
    for i, k in sorted(np.ndindex(distances.shape), key=lambda pair: float(distances[pair])):
        if distances[i, k] <= threshold(level) and chosen[i] < 0 and k not in chosen:
            chosen[i] = k
    return chosen


def right_new(z: Floats, landmarks: Floats, S: Floats, level: float = LEVEL) -> list[int]:
    return [int(i) for i in np.flatnonzero(right_distances(z, landmarks, S).min(axis=1) > threshold(level))]


def right_joint(z: Floats, landmarks: Floats, C: Floats, R: Floats, level: float = LEVEL) -> list[int]:
    chosen = joint_compatibility(ExpectedSightings(landmarks, C, R, NO_ANGLE), z, level).landmarks
    return [int(k) for k in chosen]


def alone(C: Floats, R: Floats) -> Floats:
    """The covariances (l, 2, 2) of one landmark at a time."""
    return np.array([C[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] + R for k in range(len(C) // 2)])


def one_by_one(rng: np.random.Generator) -> Iterator[Arguments]:
    """A map of one landmark; one measurement; doubts along an axis, slanted, of different sizes; then one argument
    changed at a time, which a memory with an incomplete key does not see."""
    yield matrix((1, 0), (0, 2)), matrix((0, 0)), np.array([np.diag([1.0, 4.0])])
    yield matrix((3, 0)), matrix((0, 0), (4, 0), (3, 2)), np.array([np.diag([9.0, 1.0]), np.eye(2), 2.0 * np.eye(2)])
    z, landmarks = matrix((1, 1), (2, 0)), matrix((0, 0), (2, 2))
    S = np.array([matrix((2, 1), (1, 2)), matrix((1, -0.5), (-0.5, 1))])
    yield z, landmarks, S
    yield z, landmarks, S[::-1]
    yield z[::-1], landmarks, S
    yield z, landmarks + 1.0, S
    for _ in range(2):
        yield drawn_scan(rng, 3, 4)[:3]


def scans_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Each its own; one alone; second choices; a landmark that is taken; doubts that differ; all out of every gate;
    the last again, with less doubt."""
    two, same = matrix((0, 0), (2, 0)), np.array([np.eye(2)] * 2)
    yield matrix((0.5, 0), (5, 1)), matrix((0, 0), (5, 0)), same
    yield matrix((5, 1), (0.5, 0)), matrix((0, 0), (5, 0)), same
    yield matrix((20, 0), (0.75, 0)), two, same
    yield matrix((0.5, 0), (0.25, 0)), two, same
    yield matrix((0.25, 0), (0.5, 0)), two, same
    yield matrix((1.125, 0), (3.5, 0)), two, same
    yield matrix((1.125, 0), (3.5, 0)), two[::-1], same
    yield matrix((0.5, 0), (1, 0), (-0.75, 0)), matrix((0, 0)), np.array([np.eye(2)])
    yield matrix((3, 0)), matrix((0, 0), (4, 0)), np.array([np.diag([9.0, 0.25]), 0.09 * np.eye(2)])
    yield matrix((2.5, 0)), matrix((0, 0), (9, 0)), same
    yield matrix((0, 3.25), (5, 0)), matrix((0, 0), (9, 0)), same
    yield matrix((0, 2.9), (9, 0)), matrix((0, 0), (9, 0)), same
    yield matrix((0, 2.9), (9, 0)), matrix((0, 0), (9, 0)), 0.25 * same
    # As many measurements as landmarks, four, all of them in a gate; then one measurement more.
    four = matrix((0, 0), (6, 0), (0, 6), (6, 6))
    away = matrix((0.5, 0.25), (6.25, -0.75), (-0.75, 6), (6.5, 6.75))
    yield away[::-1], four, np.array([np.eye(2)] * 4)
    yield np.vstack([away, [[0.0, 1.5]]]), four, np.array([np.eye(2)] * 4)


#: Measurements, landmarks, level and seed of scans in which every known mistake shows that can show at all: a test
#: holds that.
SCANS: tuple[tuple[int, int, float, int], ...] = (
    (2, 3, 0.9, 1),
    (2, 3, 0.5, 2),
    (2, 3, 0.99, 3),
    (2, 3, 0.99, 5),
    (2, 3, 0.99, 7),
    (3, 3, 0.999, 9),
)


def any_scans(rng: np.random.Generator) -> Iterator[Arguments]:
    """With a level, the usual one and others: always the same, then in another order and at another place."""
    for shape in SCANS:
        yield steady_scan(*shape)
    for shape in SCANS:
        z, landmarks, S, level = steady_scan(*shape)
        move, order = np.round(rng.uniform(-5, 5, 2)), rng.permutation(len(landmarks))
        yield rng.permutation(z) + move, landmarks[order] + move, S[order], level


def steady_scan(m: int, n: int, level: float, seed: int) -> Arguments:
    return (*drawn_scan(np.random.default_rng(seed), m, n, level), level)


def drawn_scan(rng: np.random.Generator, m: int, n: int, level: float = LEVEL) -> tuple[Floats, Floats, Floats]:
    """Landmarks some metres apart, measurements about some of them, one of which may be nobody's."""
    while True:
        landmarks = np.round(rng.uniform(-3, 3, (n, 2)), 1)
        S = np.array([drawn_covariance(rng, 2, float(rng.uniform(0.1, 0.5))) for _ in range(n)])
        z = np.round(landmarks[rng.integers(n, size=m)] + rng.normal(0, 0.7, (m, 2)), 1)
        if is_clear((z, landmarks, S, level)):
            return z, landmarks, S


def is_clear(args: Arguments) -> bool:
    """Is no distance near the gate, and no pair as near as another that it competes with?"""
    z, landmarks, S, *level = args
    if not (len(z) and len(landmarks) == len(S) and all(map(is_covariance, S))):
        return False
    gate = threshold(level[0] if level else LEVEL)
    distances = right_distances(z, landmarks, S)
    inside = np.sort(distances[distances <= gate])
    return bool(
        np.all(np.abs(distances - gate) > MARGIN * gate) and np.all(np.diff(inside) > MARGIN * (0.01 + inside[1:]))
    )


def joint_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """The statement's, in which the first pair that is tried may leave nobody for the other; one alone between two; two
    of one landmark; a spurious one; D² near either side of a threshold, then with another C; without an error in
    common, without any, a sensor that is poor along y, then another R, landmarks of which one is known less; pairs
    whose order C must follow."""
    common, R = np.kron(np.ones((2, 2)), np.eye(2)), 0.04 * np.eye(2)
    two, apart = matrix((0, 0), (3, 0)), matrix((0, 0), (9, 0))
    yield matrix((1.8, 0), (4.6, 0)), two, common, R
    yield matrix((4.6, 0), (1.8, 0)), two, common, R
    yield matrix((1.8, 0), (4.6, 0)), two[::-1], common, R
    yield matrix((1, 0)), two, common, R
    yield matrix((2, 0)), two, common, R
    yield matrix((0.5, 0), (0.25, 0)), apart, common, R
    yield matrix((1, 0), (4.2, 0), (2.5, 2)), two, common, R
    yield matrix((0, 2.9)), apart, common, R
    yield matrix((2.45, 0), (7.95, 0)), matrix((0, 0), (5, 0)), common, R
    yield matrix((2.45, 0), (7.95, 0)), matrix((0, 0), (5, 0)), np.eye(4), R
    yield matrix((9, 9), (-9, 5)), two, common, R
    yield matrix((1.75, 0), (3.6, 0)), two, np.eye(4), R
    yield matrix((1.1, 0), (4, 0)), two, np.zeros((4, 4)), np.eye(2)
    yield matrix((0.5, 4), (9.6, -4)), apart, common, np.diag([0.04, 4.0])
    yield matrix((0.5, 4), (9.6, -4)), apart, common, 0.25 * np.eye(2)
    yield matrix((0, 7)), matrix((0, 0), (0, 10)), np.diag([0.01, 0.01, 1.0, 4.0]), R
    three = np.kron(np.ones((3, 3)), np.eye(2))
    yield matrix((1.1, 0), (3.2, 0.1), (6.5, 0)), matrix((0, 0), (1.5, 0), (5, 0)), three, R
    # Found by search: rows of C in another order than the pairs choose other landmarks. The best D², each threshold and
    # each D² of as many pairs are at least a factor of two apart.
    close, unequal = matrix((0, 0), (2, 0)), common + np.diag([0.0, 0.0, 9.0, 9.0])
    yield matrix((2, 0), (6, 0)), close, unequal, R
    yield matrix((6, 0), (2, 0)), close, unequal, R
    row = matrix((0, 0), (2, 0), (4, 0))
    yield matrix((1, 0), (5.5, 0), (0, 0)), row, three + np.diag([0.0, 0.0, 4.0, 4.0, 9.0, 9.0]), R
    # A sensor that errs along a slanted line; the last of five landmarks, and four measurements.
    yield matrix((1.75, 1.75)), apart, np.zeros((4, 4)), matrix((0.5, 0.4), (0.4, 0.5))
    yield matrix((1.75, -1.75)), apart, np.zeros((4, 4)), matrix((0.5, 0.4), (0.4, 0.5))
    five = matrix((0, 0), (9, 0), (0, 9), (9, 9), (20, 0))
    yield matrix((21, 0.1), (1.1, 9)), five, np.kron(np.ones((5, 5)), np.eye(2)), R
    yield matrix((10, 9.1), (21.2, 0), (0.9, -0.2), (10.1, 0.3)), five, np.kron(np.ones((5, 5)), np.eye(2)), R


#: As SCANS, for all measurements together.
JOINTS: tuple[tuple[int, int, float, int], ...] = (
    (2, 2, 0.9, 9),
    (2, 2, 0.5, 0),
    (2, 3, 0.99, 10),
    (2, 3, 0.5, 8),
    (2, 3, 0.99, 8),
    (2, 3, 0.99, 7),
    (2, 3, 0.9, 4),
    (3, 3, 0.99, 10),
)


def any_joints(rng: np.random.Generator) -> Iterator[Arguments]:
    """Always the same, then some of them in another order and at another place."""
    for shape in JOINTS:
        yield joint_scan(*shape)
    for shape in JOINTS[::3]:
        yield shuffled(rng, joint_scan(*shape))


@lru_cache(maxsize=64)
def joint_scan(m: int, n: int, level: float, seed: int) -> Arguments:
    """A robot off by a metre or so and by some degrees: in those asked, what is nearest is wrong, what agrees right."""
    rng = np.random.default_rng(seed)
    landmarks = np.round(rng.uniform(-3, 3, (n, 2)), 1)
    seen = landmarks - rng.uniform(-2, 2, 2)
    columns = [np.tile(np.eye(2), (n, 1)), np.column_stack([-seen[:, 1], seen[:, 0]]).reshape(-1, 1)]
    J, spread = np.hstack(columns), np.array([0.9, 0.7, 0.2])
    own = np.kron(np.diag(rng.uniform(0.01, 0.05, n)), np.eye(2))
    C = np.round((J * spread**2) @ J.T + own, 3)
    R = np.diag(np.round(rng.uniform(0.02, 0.06, 2), 2))
    order = rng.permutation(n)[:m]
    moved = landmarks + (J @ (1.2 * spread * rng.normal(size=3))).reshape(-1, 2)
    return np.round(moved[order] + rng.normal(0, 0.15, (m, 2)), 2), landmarks, C, R, level


def shuffled(rng: np.random.Generator, args: Arguments) -> Arguments:
    """The same scan, its measurements and its landmarks in another order, the whole moved by some metres."""
    z, landmarks, C, R, level = args
    move, order = np.round(rng.uniform(-5, 5, 2)), rng.permutation(len(landmarks))
    rows = (2 * order[:, None] + np.arange(2)).ravel()
    return rng.permutation(z) + move, landmarks[order] + move, C[np.ix_(rows, rows)], R, level


def decides(args: Arguments) -> bool:
    """Is there one best hypothesis, by far enough, whichever way it is sought?"""
    z, landmarks, C, R, *given = args
    level = given[0] if given else LEVEL
    if len(z) == 0 or not (is_covariance(C, least=-1e-12) and is_covariance(R, least=0.01)):
        return False
    if not is_clear((z, landmarks, alone(C, R), level)):
        return False
    expected = ExpectedSightings(landmarks, C, R, NO_ANGLE)
    try:
        found = tuple(joint_compatibility(expected, z, level).pairs)
    except AssociationError:
        return False
    return _is_clearly_best(found, list(_rivals(expected, z, level)))


def _is_clearly_best(found: Pairs, rivals: Sequence[tuple[Pairs, float, str]]) -> bool:
    """Are these the most pairs, the nearest by far of those as many, compatible in each of their parts?"""
    most = max((len(pairs) for pairs, _, answer in rivals if answer != "no"), default=0)
    if any(answer == "near" for pairs, _, answer in rivals if len(pairs) >= max(most, 1)):
        return False
    best = sorted((distance, pairs) for pairs, distance, answer in rivals if len(pairs) == most and answer == "yes")
    if not best:
        return not found
    if len(best) > 1 and best[1][0] - best[0][0] < MARGIN * (0.01 + best[1][0]):
        return False
    parts = all(answer == "yes" for pairs, _, answer in rivals if {*pairs} <= {*best[0][1]})
    return parts and best[0][1] == found


def _rivals(expected: ExpectedSightings, z: Floats, level: float) -> Iterator[tuple[Pairs, float, str]]:
    """Every hypothesis of a pair or more: its pairs, its distance, and whether it is compatible: yes, no or near."""
    for chosen in product(range(-1, len(expected)), repeat=len(z)):
        pairs = tuple((i, k) for i, k in enumerate(chosen) if k >= 0)
        if not pairs or len({k for _, k in pairs}) < len(pairs):
            continue
        distance, limit = joint_distance(expected, z, chosen), threshold(level, len(pairs))
        clear = "near" if abs(distance - limit) <= MARGIN * limit else "yes" if distance < limit else "no"
        yield pairs, distance, clear
