"""What a pose graph of the plane is: its edges, one array for each component, checked once when it is made.

A node is the pose `T_w_k` (x, y, theta) of the robot at one moment, or the position `p_w_l` (x, y) of a landmark, in
the world frame w. An edge says that pose j was measured at z = `T_i_j` from pose i, a sighting that landmark l was
measured at `p_i_l` from pose i, each with an information matrix (inverse covariance).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse import csgraph

from reference.errors import check_choice
from reference.pose_graph.errors import (
    DisconnectedGraphError,
    EdgeEndsError,
    InformationError,
    NonFiniteError,
    ParameterError,
    ShapeError,
)
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Edge = tuple[int, int, ArrayLike, ArrayLike]
Convention = Literal["difference", "g2o"]

BLOCK = 3
POINT = 2

# Shares of the largest entry of a matrix: what rounding may do to it, and the least positive eigenvalue.
SAME = 1e-9
POSITIVE = 1e-14


@dataclass(frozen=True)
class Sightings:
    """k measurements of `n_landmarks` landmarks, one array for each component.

    `i` (k,): the poses that see. `landmark` (k,): what they see. `p_i_l` (k, 2): where, in metres in the frame of the
    pose. `information` (k, 2, 2).
    """

    n_landmarks: int
    i: Indices
    landmark: Indices
    p_i_l: Floats
    information: Floats

    @classmethod
    def empty(cls) -> Sightings:
        """A graph of poses alone."""
        nobody = np.zeros(0, dtype=np.int64)
        return cls(0, nobody, nobody, np.zeros((0, POINT)), np.zeros((0, POINT, POINT)))

    @classmethod
    def from_edges(cls, n_landmarks: int, edges: Iterable[Edge]) -> Sightings:
        """The sightings given one by one as (pose, landmark, p, omega)."""
        return cls(n_landmarks, *_edge_columns(edges, POINT))


@dataclass(frozen=True)
class PoseGraph:
    """m edges between `n_poses` poses, and the sightings of landmarks.

    `i`, `j` (m,): ends of the edges. `z_i_j` (m, 3): measured poses of j in i. `information` (m, 3, 3), positive
    semidefinite: an edge may say nothing along some directions, as a match of scans in a corridor does. `fixed`: the
    poses that hold the gauge. `convention`: what information weighs, "difference" the residual (1) of residuals.py,
    "g2o" the residual (2). Raises a PoseGraphError that names the argument when these do not make a graph in which
    every node is joined to a fixed pose.
    """

    n_poses: int
    i: Indices
    j: Indices
    z_i_j: Floats
    information: Floats
    sightings: Sightings = field(default_factory=Sightings.empty)
    fixed: tuple[int, ...] = (0,)
    convention: Convention = "difference"

    def __post_init__(self) -> None:
        _check_settings(self)
        _check_shapes(self)
        _check_indices(self)
        for name, numbers, matrices in (
            ("", self.z_i_j, self.information),
            ("sightings.", self.sightings.p_i_l, self.sightings.information),
        ):
            _check_finite(f"{name}z_i_j" if not name else f"{name}p_i_l", numbers)
            _check_information(f"{name}information", matrices)
        _check_connected(self)

    @classmethod
    def from_edges(
        cls,
        n_poses: int,
        edges: Iterable[Edge],
        *,
        sightings: Sightings | None = None,
        fixed: tuple[int, ...] = (0,),
        convention: Convention = "difference",
    ) -> PoseGraph:
        """The graph of edges given one by one as (i, j, z, omega)."""
        seen = Sightings.empty() if sightings is None else sightings
        return cls(n_poses, *_edge_columns(edges, BLOCK), seen, fixed, convention)

    @property
    def n_landmarks(self) -> int:
        return self.sightings.n_landmarks

    def keep_edges(self, kept: NDArray[np.bool_]) -> PoseGraph:
        """The graph of the edges of a mask (m,), with all sightings. Raises a PoseGraphError when it falls apart."""
        _check_shape("kept", kept, self.i.shape)
        i, j, z_i_j, information = self.i[kept], self.j[kept], self.z_i_j[kept], self.information[kept]
        return replace(self, i=i, j=j, z_i_j=z_i_j, information=information)

    @cached_property
    def is_fully_informed(self) -> bool:
        """Is every information matrix of the edges positive definite, so that connected poses are determined?"""
        size = np.abs(self.information).max(axis=(1, 2), initial=0.0)
        return bool(np.all(np.linalg.eigvalsh(self.information)[:, 0] > POSITIVE * size))

    @property
    def is_closure_mask(self) -> NDArray[np.bool_]:
        """Which edges (m,) do not join one pose to the next: loop closures, by the usual numbering of poses."""
        return np.asarray(np.abs(self.j - self.i) != 1)


def _edge_columns(edges: Iterable[Edge], size: int) -> tuple[Indices, Indices, Floats, Floats]:
    """Edges (a, b, z, omega) as arrays of components; `size` is that of z."""
    listed = list(edges)
    ends = np.array([(a, b) for a, b, _, _ in listed], dtype=np.int64).reshape(-1, 2)
    z = np.array([np.asarray(z, dtype=np.float64) for _, _, z, _ in listed]).reshape(-1, size)
    omega = np.array([np.asarray(w, dtype=np.float64) for _, _, _, w in listed]).reshape(-1, size, size)
    return ends[:, 0], ends[:, 1], z, omega


def _check_settings(graph: PoseGraph) -> None:
    if graph.n_poses < 1:
        raise ShapeError("n_poses", "a graph has at least one pose")
    if graph.n_landmarks < 0:
        raise ShapeError("sightings.n_landmarks", "is negative")
    check_choice("convention", graph.convention, Convention, ParameterError)
    outside = [k for k in graph.fixed if not 0 <= k < graph.n_poses]
    if outside or not graph.fixed:
        reason = f"pose {outside[0]} of {graph.n_poses} does not exist" if outside else "no pose holds the gauge"
        raise ParameterError("fixed", reason)


def _check_shapes(graph: PoseGraph) -> None:
    m, seen = len(graph.i), graph.sightings
    k = len(seen.i)
    _check_shape("i", graph.i, (m,))
    _check_shape("j", graph.j, (m,))
    _check_shape("z_i_j", graph.z_i_j, (m, BLOCK))
    _check_shape("information", graph.information, (m, BLOCK, BLOCK))
    _check_shape("sightings.i", seen.i, (k,))
    _check_shape("sightings.landmark", seen.landmark, (k,))
    _check_shape("sightings.p_i_l", seen.p_i_l, (k, POINT))
    _check_shape("sightings.information", seen.information, (k, POINT, POINT))


def _check_shape(name: str, array: NDArray[np.generic], shape: tuple[int, ...]) -> None:
    if array.shape != shape:
        raise ShapeError(name, f"has shape {array.shape}, not {shape}")


def _check_indices(graph: PoseGraph) -> None:
    seen = graph.sightings
    for name, ends, count, kind in (
        ("i", graph.i, graph.n_poses, "pose"),
        ("j", graph.j, graph.n_poses, "pose"),
        ("sightings.i", seen.i, graph.n_poses, "pose"),
        ("sightings.landmark", seen.landmark, graph.n_landmarks, "landmark"),
    ):
        outside = np.flatnonzero((ends < 0) | (ends >= count))
        if outside.size:
            raise EdgeEndsError(name, f"edge {outside[0]} names {kind} {ends[outside[0]]} of {count}")
    loops = np.flatnonzero(graph.i == graph.j)
    if loops.size:
        raise EdgeEndsError("j", f"edge {loops[0]} joins pose {graph.i[loops[0]]} to itself")


def _check_finite(name: str, array: Floats) -> None:
    if not np.all(np.isfinite(array)):
        raise NonFiniteError(name, f"row {np.argwhere(~np.isfinite(array))[0][0]} is not finite")


def _check_information(name: str, information: Floats) -> None:
    _check_finite(name, information)
    fault = find_information_fault(information)
    if fault is not None:
        raise InformationError(name, f"matrix {fault[0]} is not {fault[1]}")


def find_information_fault(information: Floats) -> tuple[int, str] | None:
    """The first matrix of (m, s, s) that is not symmetric, or not positive semidefinite; and which of the two.

    An eigenvalue that is negative by rounding alone is a zero.
    """
    size = np.abs(information).max(axis=(1, 2), initial=0.0)
    skew = np.abs(information - information.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
    for wrong, what in (
        (skew > SAME * size, "symmetric"),
        (np.linalg.eigvalsh(information)[:, 0] < -SAME * size, "positive semidefinite"),
    ):
        if np.any(wrong):
            return int(np.argmax(wrong)), what
    return None


def _check_connected(graph: PoseGraph) -> None:
    """Every node has a path of edges and sightings to a fixed pose: landmark l is node n_poses + l, here."""
    seen, total = graph.sightings, graph.n_poses + graph.n_landmarks
    tied = np.array(graph.fixed[1:], dtype=np.int64)
    i = np.concatenate([graph.i, seen.i, np.full(len(tied), graph.fixed[0])])
    j = np.concatenate([graph.j, seen.landmark + graph.n_poses, tied])
    adjacency = sparse.coo_array((np.ones(len(i)), (i, j)), shape=(total, total))
    count, labels = csgraph.connected_components(adjacency, directed=False)
    if count > 1:
        lost = int(np.argmax(labels != labels[graph.fixed[0]]))
        node = f"pose {lost}" if lost < graph.n_poses else f"landmark {lost - graph.n_poses}"
        reason = f"{node} is not joined to pose {graph.fixed[0]}"
        raise DisconnectedGraphError("edges", reason, (lost, graph.fixed[0]))


def copy_checked_poses(graph: PoseGraph, poses: ArrayLike) -> Floats:
    """A copy (n, 3) of the poses, angles in ]-pi, pi]. Raises ShapeError or NonFiniteError."""
    array = np.array(poses, dtype=np.float64)
    _check_shape("poses", array, (graph.n_poses, BLOCK))
    _check_finite("poses", array)
    array[:, 2] = wrap_angle(array[:, 2])
    return array


def copy_checked_landmarks(graph: PoseGraph, landmarks: ArrayLike | None) -> Floats:
    """A copy (l, 2) of the landmarks, which a graph without any may leave out. Raises ShapeError or NonFiniteError."""
    array = np.zeros((0, POINT)) if landmarks is None else np.array(landmarks, dtype=np.float64)
    _check_shape("landmarks", array, (graph.n_landmarks, POINT))
    _check_finite("landmarks", array)
    return array
