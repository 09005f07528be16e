"""Pose graphs of the plane: relative measurements between poses, brought to agree by Gauss-Newton.

A node is the pose `T_w_k` (x, y, theta) of the robot at one moment, in the world frame w. An edge (i, j, z, omega)
says that pose j was measured at z = `T_i_j` from pose i, with the information matrix omega (inverse covariance).
The sum that is minimised, the first pose being held fixed, is chi2(x) = sum of e' omega e, without a factor 1/2.

Source: Grisetti, Kümmerle, Stachniss, Burgard, "A Tutorial on Graph-Based SLAM" (2010), section III, with the error
of an edge taken as the difference of components; where omega is isotropic in translation it gives the same chi2 as
the error t2v(Z^-1 Xi^-1 Xj) of g2o.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse import linalg as sparse_linalg

from reference.errors import InvalidArgumentError
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Edge = tuple[int, int, ArrayLike, ArrayLike]

BLOCK = 3
STEP_TOLERANCE = 1e-9


class PoseGraphError(InvalidArgumentError):
    """Input that is not a pose graph; `argument` names what is wrong with it."""


class ShapeError(PoseGraphError):
    """An array that has not the shape it must have."""


class EdgeIndexError(PoseGraphError):
    """An edge that names a pose outside the graph, or joins a pose to itself."""


class NonFiniteError(PoseGraphError):
    """A number that is infinite or not a number."""


class InformationError(PoseGraphError):
    """An information matrix that is not symmetric and positive definite."""


class DisconnectedGraphError(PoseGraphError):
    """Some pose has no path of edges to the first one: nothing says where it is."""


class SingularSystemError(ArithmeticError):
    """The normal equations could not be factorised."""


@dataclass(frozen=True)
class PoseGraph:
    """m edges between `n_poses` poses, one array for each component.

    `i`, `j` (m,): ends of the edges. `z_i_j` (m, 3): measured poses of j in i. `information` (m, 3, 3).
    Raises a PoseGraphError that names the argument when these do not make a graph with one optimum up to gauge.
    """

    n_poses: int
    i: Indices
    j: Indices
    z_i_j: Floats
    information: Floats

    def __post_init__(self) -> None:
        _check_shapes(self)
        _check_indices(self)
        _check_finite("z_i_j", self.z_i_j)
        _check_information(self.information)
        _check_connected(self)

    @classmethod
    def from_edges(cls, n_poses: int, edges: Iterable[Edge]) -> PoseGraph:
        """The graph of edges given one by one as (i, j, z, omega)."""
        listed = list(edges)
        ends = np.array([(i, j) for i, j, _, _ in listed], dtype=np.int64).reshape(-1, 2)
        z = np.array([np.asarray(z, dtype=np.float64) for _, _, z, _ in listed]).reshape(-1, BLOCK)
        omega = np.array([np.asarray(w, dtype=np.float64) for _, _, _, w in listed]).reshape(-1, BLOCK, BLOCK)
        return cls(n_poses, ends[:, 0], ends[:, 1], z, omega)


def _check_shapes(graph: PoseGraph) -> None:
    m = len(graph.i)
    shapes = {"i": (m,), "j": (m,), "z_i_j": (m, BLOCK), "information": (m, BLOCK, BLOCK)}
    for name, shape in shapes.items():
        if getattr(graph, name).shape != shape:
            raise ShapeError(name, f"has shape {getattr(graph, name).shape}, not {shape}")
    if graph.n_poses < 1:
        raise ShapeError("n_poses", "a graph has at least one pose")


def _check_indices(graph: PoseGraph) -> None:
    for name, ends in (("i", graph.i), ("j", graph.j)):
        outside = np.flatnonzero((ends < 0) | (ends >= graph.n_poses))
        if outside.size:
            raise EdgeIndexError(name, f"edge {outside[0]} names pose {ends[outside[0]]} of {graph.n_poses}")
    loops = np.flatnonzero(graph.i == graph.j)
    if loops.size:
        raise EdgeIndexError("j", f"edge {loops[0]} joins pose {graph.i[loops[0]]} to itself")


def _check_finite(name: str, array: Floats) -> None:
    if not np.all(np.isfinite(array)):
        raise NonFiniteError(name, f"row {np.argwhere(~np.isfinite(array))[0][0]} is not finite")


def _check_information(information: Floats) -> None:
    _check_finite("information", information)
    size = np.abs(information).max(axis=(1, 2), initial=0.0)
    skew = np.abs(information - information.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
    for wrong, what in (
        (skew > 1e-9 * size, "symmetric"),
        (np.linalg.eigvalsh(information)[:, 0] <= 1e-14 * size, "positive definite"),
    ):
        if np.any(wrong):
            raise InformationError("information", f"matrix {np.argmax(wrong)} is not {what}")


def _check_connected(graph: PoseGraph) -> None:
    shape = (graph.n_poses, graph.n_poses)
    adjacency = sparse.coo_array((np.ones(len(graph.i)), (graph.i, graph.j)), shape=shape)
    count, labels = csgraph.connected_components(adjacency, directed=False)
    if count > 1:
        raise DisconnectedGraphError("edges", f"pose {np.argmax(labels != labels[0])} is not joined to pose 0")


def residuals(T_w_i: Floats, T_w_j: Floats, z_i_j: Floats) -> Floats:
    """Errors (..., 3) of edges, for poses and measurements (..., 3); zero where they agree, the angle in ]-pi, pi].

    e = [R(theta_i)' (t_j - t_i) - t_z,  wrap(theta_j - theta_i - theta_z)]                                (1)
    """
    c, s = np.cos(T_w_i[..., 2]), np.sin(T_w_i[..., 2])
    dx, dy, dtheta = np.moveaxis(T_w_j - T_w_i, -1, 0)
    turned = np.stack([c * dx + s * dy, -s * dx + c * dy, dtheta], axis=-1) - z_i_j
    turned[..., 2] = wrap_angle(turned[..., 2])
    return turned


def group_residuals(T_w_i: Floats, T_w_j: Floats, z_i_j: Floats) -> Floats:
    """Errors (..., 3) in the convention of g2o: the pose of j seen from where the measurement puts it.

    t2v(Z^-1 Xi^-1 Xj): (1) with its translation turned by -theta_z                                        (2)
    """
    e = residuals(T_w_i, T_w_j, z_i_j)
    c, s = np.cos(z_i_j[..., 2]), np.sin(z_i_j[..., 2])
    return np.stack([c * e[..., 0] + s * e[..., 1], -s * e[..., 0] + c * e[..., 1], e[..., 2]], axis=-1)


def jacobians(T_w_i: Floats, T_w_j: Floats) -> tuple[Floats, Floats]:
    """Derivatives of (1) with respect to the two poses, (m, 3, 3) each, for poses (m, 3).

    de/dx_i = [[-R', dR'/dtheta (t_j - t_i)], [0, -1]],   de/dx_j = [[R', 0], [0, 1]],   R = R(theta_i)     (3)
    """
    c, s = np.cos(T_w_i[:, 2]), np.sin(T_w_i[:, 2])
    dx, dy = (T_w_j - T_w_i)[:, :2].T
    by_j = np.zeros((len(T_w_i), BLOCK, BLOCK))
    by_j[:, 0, 0] = by_j[:, 1, 1] = c
    by_j[:, 0, 1], by_j[:, 1, 0] = s, -s
    by_j[:, 2, 2] = 1.0
    by_i = -by_j
    by_i[:, 0, 2] = -s * dx + c * dy
    by_i[:, 1, 2] = -c * dx - s * dy
    return by_i, by_j


def edge_residuals(graph: PoseGraph, poses: Floats) -> Floats:
    """Errors (m, 3) of all edges for poses (n, 3)."""
    return residuals(poses[graph.i], poses[graph.j], graph.z_i_j)


def edge_chi2(graph: PoseGraph, poses: Floats) -> Floats:
    """The share (m,) of each edge in chi2: e' omega e."""
    e = edge_residuals(graph, poses)
    weighted = np.matmul(graph.information, e[:, :, None])[:, :, 0]
    return np.asarray((e * weighted).sum(axis=1))


def chi2(graph: PoseGraph, poses: Floats) -> float:
    """The sum that is minimised."""
    return float(edge_chi2(graph, poses).sum())


def _sums(slots: Indices, values: Floats, size: int) -> Floats:
    """The sum (size,) of the values that fall in each slot."""
    return np.asarray(np.bincount(slots, values, minlength=size), dtype=np.float64)


class NormalEquations:
    """H = J' omega J and b = J' omega e over all poses but the first; where H is non-zero is worked out once."""

    def __init__(self, graph: PoseGraph) -> None:
        self.graph = graph
        self.size = BLOCK * (graph.n_poses - 1)
        at_i, at_j = (BLOCK * (ends[:, None] - 1) + np.arange(BLOCK) for ends in (graph.i, graph.j))
        self._rhs_rows = np.stack([at_i, at_j]).ravel()
        self._rhs_free = self._rhs_rows >= 0
        rows = np.stack([at_i, at_i, at_j, at_j])[..., :, None]
        columns = np.stack([at_i, at_j, at_i, at_j])[..., None, :]
        rows, columns = (a.ravel() for a in np.broadcast_arrays(rows, columns))
        self._free = (rows >= 0) & (columns >= 0)
        cells, self._slots = np.unique(columns[self._free] * self.size + rows[self._free], return_inverse=True)
        self._cells = len(cells)
        columns_of_cells, self._indices = np.divmod(cells, max(self.size, 1))
        self._starts = np.searchsorted(columns_of_cells, np.arange(self.size + 1))

    def assemble(self, poses: Floats) -> tuple[sparse.csc_array, Floats]:
        """H, symmetric (3n - 3, 3n - 3), and b (3n - 3,), for poses (n, 3)."""
        graph = self.graph
        e = edge_residuals(graph, poses)
        by_i, by_j = jacobians(poses[graph.i], poses[graph.j])
        weighted_i, weighted_j = (by.transpose(0, 2, 1) @ graph.information for by in (by_i, by_j))
        blocks = np.stack([weighted_i @ by_i, weighted_i @ by_j, weighted_j @ by_i, weighted_j @ by_j])
        data = _sums(self._slots, blocks.ravel()[self._free], self._cells)
        H = sparse.csc_array((data, self._indices, self._starts), shape=(self.size, self.size))
        gradient = np.stack([weighted_i @ e[:, :, None], weighted_j @ e[:, :, None]]).ravel()
        b = _sums(self._rhs_rows[self._rhs_free], gradient[self._rhs_free], self.size)
        return H, b

    def step(self, poses: Floats) -> Floats:
        """The Gauss-Newton step (n, 3): H step = -b, zero for the first pose. Raises SingularSystemError."""
        H, b = self.assemble(poses)
        try:
            factor = sparse_linalg.splu(
                H, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise SingularSystemError(f"the normal equations are singular: {error}") from error
        return np.concatenate([np.zeros(BLOCK), factor.solve(-b)]).reshape(-1, BLOCK)


@dataclass(frozen=True)
class Solution:
    """How an optimisation ended. `chi2` holds its value at the start and after each of the `iterations` steps."""

    poses: Floats
    chi2: tuple[float, ...]
    converged: bool

    @property
    def iterations(self) -> int:
        return len(self.chi2) - 1


def gauss_newton(
    graph: PoseGraph, poses: ArrayLike, *, max_iterations: int = 50, tolerance: float = STEP_TOLERANCE
) -> Solution:
    """Minimise chi2 from `poses` (n, 3), the first one held fixed; angles come back in ]-pi, pi].

    Converged: the largest component of the last step was below `tolerance`. An iteration that leaves the finite
    numbers ends the search, not converged. Raises a PoseGraphError for `poses` that do not fit the graph.
    """
    current = _checked_poses(graph, poses)
    history = [chi2(graph, current)]
    if graph.n_poses == 1:
        return Solution(current, tuple(history), True)
    equations = NormalEquations(graph)
    for _ in range(max_iterations):
        step = equations.step(current)
        current = current + step
        current[:, 2] = wrap_angle(current[:, 2])
        history.append(chi2(graph, current))
        if not np.isfinite(history[-1]) or np.max(np.abs(step)) < tolerance:
            return Solution(current, tuple(history), bool(np.isfinite(history[-1])))
    return Solution(current, tuple(history), False)


def _checked_poses(graph: PoseGraph, poses: ArrayLike) -> Floats:
    array = np.array(poses, dtype=np.float64)
    if array.shape != (graph.n_poses, BLOCK):
        raise ShapeError("poses", f"have shape {array.shape}, not {(graph.n_poses, BLOCK)}")
    _check_finite("poses", array)
    array[:, 2] = wrap_angle(array[:, 2])
    return array
