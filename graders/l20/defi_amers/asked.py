"""The maps that the checks ask about: from two poses and one landmark to a tour of twenty poses and eight landmarks.

Every landmark is seen, every graph is connected, and no list is empty.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from functools import cache, lru_cache, partial

import numpy as np

from graders.core.contract.values import Floats
from graders.l20.defi_amers.maps import PLENTY, Map, around, noisy, seen_from, settles, sight, slanted, various
from graders.l20.slam_graphe.graphs import along, edge, facing_one_way, rows
from reference.se2 import relative, wrap_angle

QUARTER = math.pi / 2

# Maps that never change come before those that are drawn; on those of these seeds the known wrong programs fail.
TELLING = {"systems": 0, "exact": 6, "wrapping": 0, "shared": 2, "weighted": 0, "turning": 1, "tour": 2}


def cached(draw: Callable[[np.random.Generator], Iterable[Map]]) -> Callable[[np.random.Generator], Sequence[Map]]:
    """Keep the maps of one seed with what was computed of them."""

    @lru_cache(maxsize=64)
    def from_seed(seed: int) -> tuple[Map, ...]:
        return tuple(draw(np.random.default_rng(seed)))

    return lambda rng: from_seed(int(rng.integers(2**62)))


def telling(maps: str) -> np.random.Generator:
    """The generator of those of the maps that never change."""
    return np.random.default_rng(TELLING[maps])


def small_system(rng: np.random.Generator, n: int, m: int) -> Map:
    """Any poses and landmarks, off what the measurements say, all weights unlike: H and b are asked of any point."""
    corner = (2.0, 2.0, 1.3)
    poses = np.round(rng.uniform(np.negative(corner), corner, (n, 3)), 1)
    landmarks = np.round(rng.uniform(-3, 3, (m, 2)), 1)
    ends = [*along(n), (n - 1, 0)]
    weights = various(rng)
    edges = []
    for k, (i, j) in enumerate(ends):
        z = np.round(relative(poses[i], poses[j]) + rng.uniform(-0.5, 0.5, 3), 1)
        edges.append(edge(i, j, z, *weights(k)))
    edges.append(edge(0, 1, edges[0][2] + (0.4, -0.3, 0.2), *weights(0)))
    pairs = [(int(rng.integers(n)), j) for j in range(m)] + [(i, int(rng.integers(m))) for i in range(n)]
    pairs.append(pairs[0])
    sightings = []
    for i, j in pairs:
        z = np.round(seen_from(poses[i], landmarks[j]) + rng.uniform(-1.0, 1.0, 2), 1)
        sightings.append(sight(i, j, z, slanted(rng)))
    order = rng.permutation(len(edges))
    return Map(poses, landmarks, tuple(edges[k] for k in order), tuple(sightings))


@cached
def systems(rng: np.random.Generator) -> Iterable[Map]:
    """Whole numbers and quarter turns first: one landmark seen where it is, then one step aside, then from pose 1."""
    still = rows((0, 0, 0), (1, 0, 0))
    step = (edge(0, 1, (1, 0, 0)),)
    beacon = rows((2, 1))
    yield Map(still, beacon, step, (sight(0, 0, (2, 1)),))
    yield Map(still, beacon, step, (sight(0, 0, (1, 3)),))
    yield Map(still, beacon, (edge(0, 1, (3, 1, 0)),), (sight(0, 0, (2, 1)),))
    yield Map(still, beacon, step, (sight(1, 0, (1, 3), 2.0),))
    turned = rows((1, 2, QUARTER), (1, 4, 0))
    yield Map(
        turned,
        rows((0, 3), (3, 4)),
        (edge(0, 1, (1, 1, -QUARTER), 2.0, 3.0),),
        (sight(1, 1, (1, 1)), sight(0, 0, (2, 2))),
    )


@cache
def _linked_systems() -> tuple[Map, ...]:
    first = Map(rows((0, 0, 0), (1, 0, 0)), rows((2, 1)), (edge(0, 1, (3, 1, 0)),), (sight(0, 0, (2, 1)),))
    return first, small_system(telling("systems"), 3, 2)


def linked_systems(rng: np.random.Generator) -> Sequence[Map]:
    """The same ones always: one edge, then edges of any weights."""
    return _linked_systems()


@cached
def random_systems(rng: np.random.Generator) -> Iterable[Map]:
    """Any point, any weights, sightings of which the information is not diagonal, pairs seen twice."""
    yield small_system(telling("systems"), 3, 2)
    yield small_system(telling("systems"), 2, 4)
    yield small_system(rng, 3, 2)
    yield small_system(rng, 4, 3)


@cached
def wrapping_systems(rng: np.random.Generator) -> Iterable[Map]:
    """Edges whose angle leaves ]-pi, pi] before it is brought back."""
    beacon, seen = rows((1, 1)), (sight(0, 0, (1, 1)),)
    for sign in (1.0, -1.0):
        # The headings differ by a small angle across the half turn.
        poses = rows((0, 0, sign * 3), (-1, 0, -sign * 3))
        yield Map(poses, beacon, (edge(0, 1, (1, 0, 0)),), seen)
        # No difference of two angles leaves the interval, but the error does.
        poses = rows((0, 0, -sign * 1.5), (1, 0, sign * 1.5))
        yield Map(poses, beacon, (edge(0, 1, (1, 0, -sign * 3)),), seen)
        # Nothing leaves the interval, and the error is more than a quarter turn.
        poses = rows((0, 0, 0), (1, 0, sign * 1.5))
        yield Map(poses, beacon, (edge(0, 1, (1, 0, -sign * 1)),), seen)
    for source in (telling("wrapping"), rng):
        for sign in (1.0, -1.0):
            first, second = sign * source.uniform(2.6, 3.0), -sign * source.uniform(2.6, 3.0)
            poses = np.round(np.column_stack([source.uniform(-2, 2, (2, 2)), [first, second]]), 1)
            z = relative(poses[0], poses[1]) + source.uniform(-0.3, 0.3, 3)
            yield Map(poses, beacon, (edge(0, 1, np.round([*z[:2], wrap_angle(z[2])], 1), 1.0, 2.0),), seen)


def line(last: float) -> Map:
    """Two poses one metre apart as odometry says, and a landmark that they place differently: 3 to share, 1 + 1 + 1."""
    edges = (edge(0, 1, (2, 0, 0)),)
    return Map(rows((0, 0, 0), (2, 0, 0)), rows((4, 0)), edges, (sight(1, 0, (2, 0)), sight(0, 0, (last, 0))))


@cached
def exact(rng: np.random.Generator) -> Iterable[Map]:
    """Every measurement can be satisfied: a landmark to be put where it is seen, then poses with it.

    None is drawn: where all errors vanish, a wrong Jacobian ends at the optimum or not by chance.
    """
    edges = (edge(0, 1, (2, 0, 0)),)
    yield Map(rows((0, 0, 0), (2, 0, 0)), rows((3, 0)), edges, (sight(0, 0, (3, 2)),))
    yield Map(rows((1, 2, QUARTER), (1, 4, QUARTER)), rows((1, 5)), edges, (sight(1, 0, (2, 1)),))
    yield Map(
        rows((0, 0, 0), (1, 0, 0)),
        rows((3, 0), (0, 3)),
        (edge(0, 1, (2, 1, QUARTER)),),
        (sight(1, 0, (1, 1)), sight(0, 1, (1, 2))),
    )
    source = telling("exact")
    yield moved_apart(source)
    yield moved_apart(source)


def moved_apart(rng: np.random.Generator) -> Map:
    """Four poses and two landmarks that agree with all measurements, all but the first pose moved."""
    truth = facing_one_way(rng, 4)
    landmarks = around(rng, 2, 2.5)
    edges = tuple(edge(i, j, relative(truth[i], truth[j])) for i, j in along(4))
    sightings = tuple(sight(i, j, seen_from(truth[i], landmarks[j])) for i, j in ((0, 0), (2, 0), (3, 1), (1, 1)))
    while True:
        moved = np.round(rng.uniform((-0.4, -0.4, -0.25), (0.4, 0.4, 0.25), (3, 3)), 1)
        start = np.vstack([truth[:1], truth[1:] + moved])
        found = Map(start, np.round(landmarks + rng.uniform(-0.5, 0.5, (2, 2)), 1), edges, sightings)
        if settles(found):
            return found


@cached
def shared(rng: np.random.Generator) -> Iterable[Map]:
    """Measurements that disagree, all of one weight; landmarks seen again are all that closes the loop."""
    yield line(7.0)
    for source in (telling("shared"), rng):
        truth = facing_one_way(source, 4)
        pairs = [(0, 0), (3, 0), (1, 1), (2, 1), (0, 1), (3, 0)]
        yield noisy(source, truth, around(source, 2, 2.5), pairs, noise=(0.3, 0.2), sight_noise=0.3)


@cached
def weighted(rng: np.random.Generator) -> Iterable[Map]:
    """Weights: two sightings of unlike information, then matrices that are not diagonal."""
    sure = (sight(1, 0, (2, 0)), sight(0, 0, (9, 0), 2.0))
    yield Map(rows((0, 0, 0), (2, 0, 0)), rows((4, 0)), (edge(0, 1, (2, 0, 0)),), sure)
    for source in (telling("weighted"), rng):
        truth, weights = facing_one_way(source, 4), various(source)
        pairs = [(0, 0), (3, 0), (1, 1), (2, 1), (0, 1), (3, 2), (2, 2)]
        yield noisy(
            source, truth, around(source, 3, 2.5), pairs, [(3, 0)],
            weights=weights, information=partial(slanted, source),
        )  # fmt: skip


@cached
def turning(rng: np.random.Generator) -> Iterable[Map]:
    """Headings that pass the half turn, both ways, in the result and in the error; the first three never change."""
    yield from turning_by_hand()
    yield turning_round(rng)


@cache
def turning_by_hand() -> tuple[Map, ...]:
    return *half_turns(), turning_round(telling("turning"))


def half_turns() -> Iterable[Map]:
    for sign in (1.0, -1.0):
        truth = rows((0, 0, sign * 3), (-1, 0, sign * (3.4 - math.tau)))
        beacon = rows((-2, 1))
        seen = tuple(sight(k, 0, seen_from(truth[k], beacon[0])) for k in range(2))
        poses = rows((0, 0, sign * 3), (-1.2, 0.1, sign * 3.1))
        yield Map(poses, beacon, (edge(0, 1, relative(truth[0], truth[1])),), seen)


def turning_round(rng: np.random.Generator) -> Map:
    truth = circle(rng, 6, 2.0)
    pairs = [(0, 0), (5, 0), (1, 1), (2, 1), (3, 2), (4, 2), (5, 2)]
    return noisy(rng, truth, around(rng, 3, 3.0), pairs, [(5, 0)], weights=various(rng))


def circle(rng: np.random.Generator, n: int, radius: float) -> Floats:
    """Poses (n, 3) of a robot that goes round once, facing where it goes, from any heading."""
    turn = math.tau * np.arange(n) / n + rng.uniform(-math.pi, math.pi)
    poses = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), wrap_angle(turn + QUARTER)])
    return np.asarray(np.round(poses, 1), dtype=np.float64)


def in_sight(truth: Floats, landmarks: Floats, reach: float) -> list[tuple[int, int]]:
    """Which poses see which landmarks."""
    away = np.linalg.norm(truth[:, None, :2] - landmarks[None], axis=2)
    return [(int(i), int(j)) for i, j in np.argwhere(away <= reach)]


def round_trip(rng: np.random.Generator, n_iter: int | None, *, closed: bool) -> Map:
    """The course's tour: 20 poses on a circle of radius 5, 8 landmarks seen within 4, with or without the closure."""
    truth = circle(rng, 20, 5.0)
    landmarks = around(rng, 8, 6.8)
    return noisy(
        rng, truth, landmarks, in_sight(truth, landmarks, 4.0), [(19, 0)] if closed else [], noise=(0.1, 0.04),
        weights=lambda k: (100.0, 625.0), information=lambda: 44.0, n_iter=n_iter,
    )  # fmt: skip


@cached
def tours(rng: np.random.Generator) -> Iterable[Map]:
    """The course's tour, which never changes, without n_iter; then one that is drawn, without its closure."""
    yield round_trip(telling("tour"), None, closed=True)
    yield round_trip(rng, PLENTY, closed=False)
