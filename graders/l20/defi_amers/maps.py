"""A map of poses and landmarks with its measurements, its system and its optimum; and how journeys are measured.

The information of an edge is diag(a, a, b), for which both usual conventions of its error give one H and one b; that of
a sighting is any symmetric positive matrix. Plain Gauss-Newton settles within `MAX_STEPS` iterations on what is judged,
whereas `slam_amers` has twice as many, or its default.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graders.core.compare.comparison import Mismatch
from graders.core.contract.program import StudentFault
from graders.core.contract.values import Floats, Value
from graders.l20.slam_graphe.graphs import Edge, Pair, Weights, along, measure, odometry
from reference import pose_graph
from reference.pose_graph import NormalEquations, PoseGraph, Sightings
from reference.se2 import relative

MAX_STEPS = 7
PLENTY = 20

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
        found = equations.assemble(equations.join_state(self.poses, self.landmarks))
        upper = equations.pattern.upper_triangle(found.upper_entries).toarray()
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


def slanted(rng: np.random.Generator) -> Floats:
    """An information (2, 2) that is not diagonal, in one decimal."""
    a, b = rng.choice([1.0, 2.0, 4.0, 9.0], 2, replace=False)
    c = 0.1 * round(rng.choice([-1.0, 1.0]) * rng.uniform(3.0, 6.0) * math.sqrt(a * b))
    return np.array([[a, c], [c, b]], dtype=np.float64)


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


@dataclass(frozen=True)
class Failure:
    """A map on which a function is wrong: what came back and why it is wrong, or the fault."""

    one: Map
    got: Value
    mismatch: Mismatch | None
    fault: StudentFault | None
