"""The edges that submissions are graded on: headings that are multiples of a quarter turn by hand, then any.

Where derivatives are asked, the angle of the residual stays a hundredth of a radian away from the half turn, so that
finite differences do not cross it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Arguments, Floats
from graders.l19.matrices import drawn_covariance, is_covariance, matrix
from graders.l20.slam_graphe.residual import QUARTER, pose, simple_edges, stays, wrapping_edges
from reference.pose_graph import jacobians, residuals

#: Radians that the angle of a residual stays away from the half turn, at least, and metres between two poses, at most.
CLEAR, FAR = 0.01, 12.0


def right_residual(xi: Floats, xj: Floats, z: Floats) -> Floats:
    return residuals(xi, xj, z)


def right_jacobians(xi: Floats, xj: Floats, z: Floats) -> tuple[Floats, Floats]:
    by_i, by_j = jacobians(xi[None], xj[None])
    return by_i[0], by_j[0]


def right_contribution(xi: Floats, xj: Floats, z: Floats, omega: Floats) -> tuple[Floats, Floats]:
    J = np.hstack(right_jacobians(xi, xj, z))
    return J.T @ omega @ J, J.T @ omega @ residuals(xi, xj, z)


def whole_edges(rng: np.random.Generator) -> Iterator[Arguments]:
    """None has an angle that wraps; two, always the same, have angles of more than a quarter turn."""
    yield from simple_edges(rng)
    yield pose(0.5, 1, 0.4), pose(2, -1.5, 2.6), pose(1, 0.5, -0.2)
    yield pose(-1, 2, 0.7), pose(1.5, 0.5, -1.4), pose(0.5, -1, 0.3)
    while True:
        args = drawn_edge(rng)
        if stays(args):
            break
    yield args


def wrapped_edges(rng: np.random.Generator) -> Iterator[Arguments]:
    yield from wrapping_edges(rng)


def upright_edges(rng: np.random.Generator) -> Iterator[Arguments]:
    """The robot looks along an axis of the world: every derivative is a whole number."""
    yield pose(0, 0, 0), pose(2, 1, 0), pose(1.5, 0, 0)
    yield pose(0, 0, 0), pose(3, 0, 0), pose(2, 1, 0)
    yield pose(1, 2, QUARTER), pose(1, 4, 0), pose(2, 0, 1)
    yield pose(1, 0, -QUARTER), pose(3, 1, QUARTER), pose(1, 1, 1)
    yield pose(2, 1, math.pi), pose(-1, 2, 2.5), pose(2, -1, 1)
    yield pose(1, 1, 0), pose(1, 1, 1), pose(0, 0, 0.5)


def any_edges(rng: np.random.Generator) -> Iterator[Arguments]:
    """Any headings; the second and third have angles that wrap, the fourth a residual that is far from null."""
    yield pose(0.5, 1, 0.4), pose(2, -1.5, 2.6), pose(1, 0.5, -0.2)
    yield pose(1, 0, 2.5), pose(0, 2, -2.3), pose(1, 1, -0.9)
    yield pose(-1, 0.5, -2.9), pose(1, -2, 2.8), pose(2, 0.3, 0.4)
    yield pose(1.2, -0.7, -0.8), pose(-2.1, 1.6, 0.7), pose(-3, 2, -0.6)
    for _ in range(4):
        yield drawn_edge(rng)


def drawn_edge(rng: np.random.Generator) -> Arguments:
    while True:
        args = tuple(pose(*np.round(rng.uniform((-4, -4, -3.1), (4, 4, 3.1)), 1)) for _ in range(3))
        if is_edge(args) and min(np.abs(args[1] - args[0])) > 0.2 and abs(math.sin(2.0 * args[0][2])) > 0.2:
            return args


def contributions_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Weights of one, then of each component, then correlated."""
    yield pose(0, 0, 0), pose(2, 1, 0), pose(1, 1, 0), np.eye(3)
    yield pose(0, 0, 0), pose(2, 1, 0), pose(1.5, 0, 0), np.diag([2.0, 2.0, 5.0])
    yield pose(1, 2, QUARTER), pose(1, 4, 0), pose(1, 0, -1), matrix((2, 1, 0), (1, 3, 0), (0, 0, 4))
    yield pose(0, 0, 0), pose(1, 0, 0), pose(1, 0, 0), np.diag([1.0, 4.0, 9.0])
    yield pose(1, 2, QUARTER), pose(1, 4, 0), pose(1, 0, -1), matrix((400, 100, 0), (100, 300, 50), (0, 50, 900))


def any_contributions(rng: np.random.Generator) -> Iterator[Arguments]:
    """An angle that wraps, then a sure measurement that is nearly satisfied, then any."""
    yield pose(1, 0, 0.3), pose(0, 2, -2), pose(1, 1, 1.4), matrix((2, 1, 0), (1, 3, 0), (0, 0, 4))
    yield pose(0.5, 1, 0.4), pose(2, -1.5, 1.3), pose(0.4, -2.9, 0.9), np.diag([20.0, 20.0, 40.0])
    yield (*next(any_edges(rng)), matrix((2, 0.5, -0.3), (0.5, 1, 0.2), (-0.3, 0.2, 3)))
    for _ in range(4):
        yield (*drawn_edge(rng), drawn_covariance(rng, 3))


def is_edge(args: Arguments) -> bool:
    """Is the angle of the residual clear of the half turn, and are the poses near each other?"""
    xi, xj, z = args[:3]
    near = float(np.max(np.abs(np.concatenate([xi[:2] - xj[:2], z[:2]])))) <= FAR
    return near and bool(abs(residuals(xi, xj, z)[2]) < math.pi - CLEAR)


def is_weighed_edge(args: Arguments) -> bool:
    return is_edge(args) and is_covariance(args[3])


def edge_to_keep(rng: np.random.Generator) -> Arguments:
    return pose(1, 0, 3.0), pose(0, 2, -3.0), pose(1, 1, -1.0)
