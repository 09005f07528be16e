"""The maps that `systeme` and `slam_amers` are given: from two poses and one landmark to a tour of twenty poses.

Every landmark is seen, every graph is connected, and no list is empty. The information of an edge is diag(a, a, b), for
which both usual conventions of its error give one H and one b; that of a sighting is any symmetric positive matrix.
Plain Gauss-Newton settles within `MAX_STEPS` iterations, whereas `slam_amers` has twice as many, or its default.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from graders.core.contract.values import Floats, Value
from graders.l20.slam_graphe.graphs import Edge, Pair, Weights, along, edge, facing_one_way, measure, odometry, rows
from reference import pose_graph
from reference.pose_graph import NormalEquations, PoseGraph, Sightings
from reference.se2 import relative, wrap_angle

QUARTER = math.pi / 2
MAX_STEPS = 7
PLENTY = 20

# Maps that never change come before those that are drawn; these seeds are such that the known wrong programs fail there.
TELLING = {"systems": 0, "exact": 6, "wrapping": 0, "shared": 2, "weighted": 0, "turning": 1, "tour": 0}

Sighting = tuple[int, int, Floats, Floats]


@dataclass(frozen=True)
class Map:
    """What the two functions are called with. `n_iter` None: `slam_amers` is left to its default.

    A map that is not `judged` is only looked at, for a diagnosis.
    """

    poses: Floats
    landmarks: Floats
    edges: tuple[Edge, ...]
    sightings: tuple[Sighting, ...]
    n_iter: int | None = PLENTY
    judged: bool = True

    @property
    def at(self) -> dict[str, Value]:
        """The arguments of `systeme`."""
        edges, sightings = list(self.edges), list(self.sightings)
        return {"poses": self.poses, "amers": self.landmarks, "aretes": edges, "observations": sightings}

    @property
    def inputs(self) -> dict[str, Value]:
        """The arguments of `slam_amers`."""
        return self.at if self.n_iter is None else {**self.at, "n_iter": self.n_iter}

    @cached_property
    def model(self) -> PoseGraph:
        seen = Sightings.from_edges(len(self.landmarks), self.sightings)
        return PoseGraph.from_edges(len(self.poses), self.edges, sightings=seen)

    @cached_property
    def system(self) -> tuple[Floats, Floats]:
        """H (s, s) and b (s,) where the map is given, no pose held: s = 3n + 2m, poses first."""
        equations = NormalEquations(self.model, free_gauge=True)
        found = equations.assemble(equations.state(self.poses, self.landmarks))
        upper = equations.pattern.upper(found.data).toarray()
        return upper + np.triu(upper, 1).T, found.b

    @cached_property
    def solution(self) -> pose_graph.Solution:
        """The optimum, the first pose held."""
        return pose_graph.gauss_newton(self.model, self.poses, self.landmarks, max_iterations=30)

    @property
    def optimum(self) -> tuple[Floats, Floats]:
        return self.solution.poses, self.solution.landmarks

    def chi2(self, poses: Floats, landmarks: Floats) -> float:
        return pose_graph.chi2(self.model, poses, landmarks)

    def shares(self, poses: Floats, landmarks: Floats) -> Floats:
        """The share of each edge, then of each sighting, in chi2."""
        edges = pose_graph.edge_chi2(self.model, poses)
        return np.concatenate([edges, pose_graph.sighting_chi2(self.model, poses, landmarks)])


def settles(one: Map) -> bool:
    """Does plain Gauss-Newton reach the optimum from the start, at ease?"""
    return one.solution.converged and one.solution.iterations <= MAX_STEPS


def sight(i: int, j: int, z: Sequence[float] | Floats, omega: Floats | float = 1.0) -> Sighting:
    """Landmark j seen from pose i; a number stands for so many times the identity."""
    weight = np.diag([omega, omega]) if isinstance(omega, int | float) else omega
    return i, j, np.array(z, dtype=np.float64), np.array(weight, dtype=np.float64)


def seen_from(pose: Floats, landmark: Floats) -> Floats:
    """Where a landmark (2,) stands in the frame of a pose."""
    return np.asarray(relative(pose, np.array([*landmark, 0.0])))[:2]


def cached(draw: Callable[[np.random.Generator], Iterable[Map]]) -> Callable[[np.random.Generator], Sequence[Map]]:
    """Keep the maps of one seed with what was computed of them."""

    @lru_cache(maxsize=64)
    def from_seed(seed: int) -> tuple[Map, ...]:
        return tuple(draw(np.random.default_rng(seed)))

    return lambda rng: from_seed(int(rng.integers(2**62)))


def telling(maps: str) -> np.random.Generator:
    """The generator of those of the maps that never change."""
    return np.random.default_rng(TELLING[maps])


def slanted(rng: np.random.Generator) -> Floats:
    """An information (2, 2) that is not diagonal, in one decimal."""
    a, b = rng.choice([1.0, 2.0, 4.0, 9.0], 2, replace=False)
    c = 0.1 * round(rng.choice([-1.0, 1.0]) * rng.uniform(3.0, 6.0) * math.sqrt(a * b))
    return np.array([[a, c], [c, b]])


def various(rng: np.random.Generator) -> Weights:
    """Weights (a, b) of edges, unlike from one to another."""
    return lambda k: (float(rng.choice([1, 4, 9])), float(rng.choice([2, 10, 25])))


Information = Callable[[], Floats | float]


def look(
    rng: np.random.Generator, truth: Floats, landmarks: Floats, pairs: Sequence[tuple[int, int]], noise: float,
    information: Information,
) -> tuple[Sighting, ...]:  # fmt: skip
    """Sightings of these (pose, landmark) with a noise, in two decimals."""
    made = []
    for i, j in pairs:
        z = seen_from(truth[i], landmarks[j]) + noise * rng.normal(size=2).clip(-2, 2)
        made.append(sight(i, j, np.round(z, 2), information()))
    return tuple(made)


def placed(poses: Floats, sightings: Sequence[Sighting], count: int) -> Floats:
    """Where the first sighting of each landmark puts it, in two decimals."""
    places = np.zeros((count, 2))
    for i, j, z, _ in reversed(sightings):
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        places[j] = poses[i, 0] + c * z[0] - s * z[1], poses[i, 1] + s * z[0] + c * z[1]
    return np.round(places, 2)


def noisy(
    rng: np.random.Generator,
    truth: Floats,
    landmarks: Floats,
    pairs: Sequence[tuple[int, int]],
    closures: Sequence[tuple[int, int]] = (),
    *,
    noise: Pair = (0.2, 0.12),
    sight_noise: float = 0.2,
    weights: Weights = lambda k: (1.0, 1.0),
    information: Information = lambda: 1.0,
    n_iter: int | None = PLENTY,
) -> Map:
    """A journey measured with noise, started from its odometry; edges and sightings in any order."""
    while True:
        ends = [*along(len(truth)), *closures]
        edges = measure(rng, truth, ends, noise, [weights(k) for k in range(len(ends))])
        sightings = look(rng, truth, landmarks, pairs, sight_noise, information)
        start = odometry(truth[0], edges, len(truth))
        places = placed(start, sightings, len(landmarks))
        shuffled = tuple(edges[k] for k in rng.permutation(len(edges)))
        found = Map(start, places, shuffled, tuple(sightings[k] for k in rng.permutation(len(sightings))), n_iter)
        if settles(found):
            return found


def around(rng: np.random.Generator, count: int, radius: float) -> Floats:
    """Landmarks (count, 2) about a circle, in one decimal."""
    turn = math.tau * (np.arange(count) + rng.uniform(0.2, 0.8)) / count
    return np.round(radius * np.column_stack([np.cos(turn), np.sin(turn)]) + rng.uniform(-0.4, 0.4, (count, 2)), 1)


def small_system(rng: np.random.Generator, n: int, m: int) -> Map:
    """Any poses and landmarks far from what any measurements say, all weights unlike: H and b are asked of any point."""
    poses = np.round(np.column_stack([rng.uniform(-2, 2, (n, 2)), rng.uniform(-1.3, 1.3, n)]), 1)
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
    yield Map(turned, rows((0, 3), (3, 4)), (edge(0, 1, (1, 1, -QUARTER), 2.0, 3.0),), (sight(1, 1, (1, 1)), sight(0, 0, (2, 2))))


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
    yield Map(rows((0, 0, 0), (1, 0, 0)), rows((3, 0), (0, 3)), (edge(0, 1, (2, 1, QUARTER)),), (sight(1, 0, (1, 1)), sight(0, 1, (1, 2))))
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
            weights=weights, information=lambda s=source: slanted(s),
        )  # fmt: skip


@cached
def turning(rng: np.random.Generator) -> Iterable[Map]:
    """Headings that pass the half turn, both ways, in the result and in the error."""
    for sign in (1.0, -1.0):
        truth = rows((0, 0, sign * 3), (-1, 0, sign * (3.4 - math.tau)))
        beacon = rows((-2, 1))
        seen = tuple(sight(k, 0, seen_from(truth[k], beacon[0])) for k in range(2))
        poses = rows((0, 0, sign * 3), (-1.2, 0.1, sign * 3.1))
        yield Map(poses, beacon, (edge(0, 1, relative(truth[0], truth[1])),), seen)
    for source in (telling("turning"), rng):
        truth = circle(source, 6, 2.0)
        pairs = [(0, 0), (5, 0), (1, 1), (2, 1), (3, 2), (4, 2), (5, 2)]
        yield noisy(source, truth, around(source, 3, 3.0), pairs, [(5, 0)], weights=various(source))


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
