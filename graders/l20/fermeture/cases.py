"""What submissions are graded on: informations of small graphs, joint covariances, closures on both sides of the gate.

No distance comes within MARGIN of its threshold. Some fall between the right threshold and those of the usual mistakes:
two or six degrees of freedom, another level, a distance that is not squared.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np
from scipy.special import gammaincinv

from graders.core.contract.values import Arguments, Floats
from graders.l19.matrices import drawn_covariance, is_covariance, matrix
from graders.l20.jacobienne_arete.cases import right_contribution, right_jacobians
from graders.l20.slam_graphe.residual import QUARTER, pose
from reference.pose_graph import residuals
from reference.se2 import relative, wrap_angle

#: Of a threshold.
MARGIN = 0.01
#: Radians between the heading of j seen from i and half a turn: there, finite differences of a residual would jump.
FACING = 0.01
LEVEL, FREEDOMS = 0.95, 3
#: Seed of the cases that never change.
TELLING = 35
#: An end of an edge, and its information.
Link = tuple[int, int, Floats]


def right_joint(H: Floats, i: int, j: int) -> Floats:
    whole = np.zeros_like(H)
    whole[3:, 3:] = np.linalg.inv(H[3:, 3:])
    which = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
    return np.asarray(whole[np.ix_(which, which)])


def right_relative(xi: Floats, xj: Floats, sigma: Floats) -> Floats:
    J = np.hstack(right_jacobians(xi, xj, np.zeros(3)))
    return np.asarray(J @ sigma @ J.T)


def right_test(
    xi: Floats, xj: Floats, z: Floats, sigma: Floats, omega: Floats, level: float = LEVEL
) -> tuple[float, bool]:
    e = residuals(xi, xj, z)
    distance = float(e @ np.linalg.solve(right_relative(xi, xj, sigma) + np.linalg.inv(omega), e))
    return distance, distance <= threshold(level)


def threshold(level: float, freedoms: int = FREEDOMS) -> float:
    return float(2.0 * gammaincinv(freedoms / 2.0, level))


def information(poses: Sequence[Floats], links: Sequence[Link]) -> Floats:
    """H (3n, 3n) of a graph whose measurements agree with its poses."""
    H = np.zeros((3 * len(poses), 3 * len(poses)))
    for i, j, omega in links:
        block, _ = right_contribution(poses[i], poses[j], relative(poses[i], poses[j]), omega)
        which = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
        H[np.ix_(which, which)] += block
    return H


def graphs_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Two poses, then three on a line, then a bend, with either pose first, and the one that is fixed."""
    one, two = np.eye(3), np.diag([2.0, 2.0, 4.0])
    line = [pose(0, 0, 0), pose(1, 0, 0), pose(3, 0, 0)]
    yield information(line[:2], [(0, 1, two)]), 0, 1
    yield information(line, [(0, 1, one), (1, 2, one)]), 0, 2
    yield information(line, [(0, 1, one), (1, 2, two)]), 1, 2
    yield information(line, [(0, 1, one), (1, 2, two)]), 2, 1
    bend = [pose(0, 0, 0), pose(2, 0, QUARTER), pose(2, 1, QUARTER), pose(0, 1, 0)]
    yield information(bend, [(0, 1, one), (1, 2, two), (2, 3, one)]), 1, 3
    yield information(bend, [(0, 1, one), (1, 2, two), (2, 3, one), (3, 0, one)]), 3, 0


def any_graphs(rng: np.random.Generator) -> Iterator[Arguments]:
    yield drawn_graph(np.random.default_rng(TELLING), 4, (1, 3))
    yield drawn_graph(np.random.default_rng(TELLING), 5, (4, 2))
    for n in (3, 5, 6):
        i, j = rng.choice(n - 1, 2, replace=False) + 1
        yield drawn_graph(rng, n, (int(i), int(j)))


def drawn_graph(rng: np.random.Generator, n: int, ends: tuple[int, int]) -> Arguments:
    """A chain with one closure; the information of each edge is its own."""
    poses = [pose(*np.round(rng.uniform((-4, -4, -3), (4, 4, 3)), 1)) for _ in range(n)]
    links: list[Link] = [(k, k + 1, drawn_covariance(rng, 3)) for k in range(n - 1)]
    links.append((n - 1, 0, drawn_covariance(rng, 3)))
    return (information(poses, links), *ends)


def pairs_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """The pose i is known; its heading alone is in doubt; both err alike; both err apart; turned by a quarter."""
    known, apart = np.diag([0.0, 0, 0, 1, 4, 9]), np.diag([1.0, 2, 3, 4, 5, 6])
    yield pose(0, 0, 0), pose(2, 1, 0), known
    yield pose(1, 1, QUARTER), pose(1, 3, 0), known
    yield pose(0, 0, 0), pose(2, 1, 0), np.diag([0.0, 0, 1, 0, 0, 0])
    yield pose(0, 0, 0), pose(2, 0, 0), np.kron(np.ones((2, 2)), np.diag([4.0, 1.0, 0.0]))
    yield pose(0, 0, 0), pose(2, 1, 0), apart
    yield pose(1, 2, -QUARTER), pose(3, 1, 0), apart


def any_pairs(rng: np.random.Generator) -> Iterator[Arguments]:
    for source in (np.random.default_rng(TELLING), rng, rng, rng):
        yield drawn_pair(source)


def drawn_pair(rng: np.random.Generator) -> Arguments:
    xi, xj = (pose(*np.round(rng.uniform((-4, -4, -3), (4, 4, 3)), 1)) for _ in range(2))
    return xi, xj, drawn_covariance(rng, 6, 0.3)


def closures_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Poses that are known, then a doubt as large as the measurement's, then the example of the statement."""
    known, both = np.zeros((6, 6)), np.diag([0.0, 0, 0, 1, 1, 1])
    here, there = pose(0, 0, 0), pose(2, 0, 0)
    yield here, there, pose(1, 0, 0), known, np.eye(3)
    yield here, there, pose(-1, 0, 0), known, np.eye(3)
    yield here, there, pose(-2, 0, 0), both, np.eye(3)
    yield here, there, pose(1, 0, 0), known, np.diag([9.0, 4.0, 1.0])
    yield here, there, pose(60, 0, 0), known, np.eye(3)
    yield here, there, pose(1, -1, 0), known, matrix((2, 1, 0), (1, 3, 0), (0, 0, 4))
    sigma = np.zeros((6, 6))
    sigma[3:, 3:] = matrix((0.01, 0, 0), (0, 1.01, 0.1), (0, 0.1, 0.01))
    for z in (pose(20, 1.5, 0), pose(21, 0, 0)):
        yield here, pose(20, 0, 0), z, sigma, np.diag([100.0, 100.0, 100.0])
    yield pose(0, 0, 3), pose(1, 0, -3), pose(-1, 0, -0.2), known, np.eye(3)


#: Distances on both sides of the thresholds, each with the level that is given, if any.
TARGETS: tuple[tuple[float, float | None], ...] = (
    (7.6, None), (8.1, None), (6.8, None), (11.0, None), (0.4, None), (30.0, None),
    (10.5, 0.99), (12.0, 0.99), (6.0, 0.9), (6.6, 0.9), (2.2, 0.5), (2.6, 0.5), (1.2, 0.2),
)  # fmt: skip


def any_closures(rng: np.random.Generator) -> Iterator[Arguments]:
    """At the usual level, which is not given."""
    yield from (args for args in _always() if len(args) == 5)
    for distance in (float(rng.uniform(0.5, 7.0)), float(rng.uniform(9.0, 40.0))):
        yield drawn_closure(rng, distance, None)


def closures_at_a_level(rng: np.random.Generator) -> Iterator[Arguments]:
    yield from (args for args in _always() if len(args) == 6)
    yield drawn_closure(rng, *drawn_target(rng))


def drawn_target(rng: np.random.Generator) -> tuple[float, float]:
    """A squared distance and a level of which the threshold is clear of it: no closure could decide otherwise."""
    while True:
        distance, level = float(rng.uniform(0.2, 12.0)), float(np.round(rng.uniform(0.3, 0.99), 2))
        if abs(distance - threshold(level)) > 2.0 * MARGIN * threshold(level):
            return distance, level


@lru_cache(maxsize=1)
def _always() -> tuple[Arguments, ...]:
    rng = np.random.default_rng(TELLING)
    return tuple(drawn_closure(rng, distance, level) for distance, level in TARGETS)


def drawn_closure(rng: np.random.Generator, distance: float, level: float | None) -> Arguments:
    """A measurement at this squared distance, and the level; angles wrap in some."""
    while True:
        xi, xj, sigma = drawn_pair(rng)
        omega = drawn_covariance(rng, 3)
        S = right_relative(xi, xj, sigma) + np.linalg.inv(omega)
        e = rng.normal(size=3)
        e *= math.sqrt(distance / (e @ np.linalg.solve(S, e)))
        z = relative(xi, xj) - e
        args = xi, xj, pose(*np.round([z[0], z[1], wrap_angle(z[2])], 3)), sigma, omega
        whole = args if level is None else (*args, level)
        if abs(e[2]) < math.pi - 0.05 and decides(whole):
            return whole


def decides(args: Arguments) -> bool:
    """Is the distance clear of the threshold, and are the weights what the statement says?"""
    level = args[5] if len(args) > 5 else LEVEL
    if not (is_covariance(args[4]) and is_covariance(args[3], least=-1e-12)) or turns_back(*args[:2]):
        return False
    limit = threshold(level)
    return bool(0.1 < level < 0.999 and abs(right_test(*args)[0] - limit) > MARGIN * limit)


def is_pair(args: Arguments) -> bool:
    return is_covariance(args[2], least=-1e-12) and not turns_back(*args[:2])


def turns_back(xi: Floats, xj: Floats) -> bool:
    """Is j turned by half a turn, as i sees it?"""
    return bool(abs(wrap_angle(xj[2] - xi[2])) > math.pi - FACING)


def graph_to_keep(rng: np.random.Generator) -> Arguments:
    return drawn_graph(np.random.default_rng(TELLING), 3, (1, 2))
