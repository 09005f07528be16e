"""How well each node is known: blocks of the inverse of H, the information of all free nodes at an estimate.

    Sigma = H^-1,  the covariance of the free unknowns given the fixed poses, to the first order              (16)

Columns of Sigma come from solves with the factor. All diagonal blocks at once come from the factor alone, by the
recursion of Takahashi: with H = L D L' and Z = H^-1, Z = L'^-1 D^-1 + Z (I - L), hence for a column j with the rows P
below its diagonal, from the last column to the first,

    Z[P, j] = -Z[P, P] L[P, j],    Z[j, j] = 1 / D[j] - L[P, j]' Z[P, j]                                      (17)

where Z[P, P] is already there, for P lies within the rows of the first of P. Source: Kaess, Dellaert, "Covariance
Recovery from a Square Root Information Matrix for Data Association" (2009), section IV.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from reference.pose_graph.errors import NodeIndexError, SingularSystemError
from reference.pose_graph.factor import Factorisation, LowerFactor, factorise, is_positive_definite
from reference.pose_graph.graph import (
    BLOCK,
    POINT,
    Floats,
    Indices,
    PoseGraph,
    copy_checked_landmarks,
    copy_checked_poses,
)
from reference.pose_graph.normal_equations import NormalEquations
from reference.pose_graph.residuals import jacobians


def joint_covariance(
    graph: PoseGraph, poses: ArrayLike, nodes: Sequence[int], landmarks: ArrayLike | None = None
) -> Floats:
    """The covariance (s, s) of some nodes together, in the world frame, each fixed pose having zeros.

    Node k < n is pose k, node n + l is landmark l. Columns of (16), one solve each. Raises a PoseGraphError for
    arguments that do not fit the graph, SingularSystemError where something is not determined.
    """
    equations, factor = _factorise_graph(graph, poses, landmarks)
    components = _unknowns_of_nodes(equations, nodes)
    covariance = np.zeros((len(components), len(components)))
    free = components < equations.pattern.size
    for column in np.flatnonzero(free):
        unit = np.zeros(equations.pattern.size)
        unit[components[column]] = 1.0
        covariance[free, column] = factor.solve(unit)[components[free]]
    return (covariance + covariance.T) / 2.0


def relative_covariance(
    graph: PoseGraph, poses: ArrayLike, i: int, j: int, landmarks: ArrayLike | None = None
) -> Floats:
    """The covariance (3, 3) of `T_i_j`, the pose of j in i, in the frame of i; no matter which pose is fixed.

    J Sigma_ij J', J the Jacobians (3) of residuals.py. Errors are those of `joint_covariance`.
    """
    current = copy_checked_poses(graph, poses)
    joint = joint_covariance(graph, current, [i, j], landmarks)
    J = np.concatenate(jacobians(current[[i]], current[[j]]), axis=2)[0]
    return np.asarray(J @ joint @ J.T)


def marginal_covariances(
    graph: PoseGraph, poses: ArrayLike, landmarks: ArrayLike | None = None
) -> tuple[Floats, Floats]:
    """The covariances of each pose (n, 3, 3) and of each landmark (l, 2, 2) in the world frame; fixed ones are zero.

    By (17), at once. Errors are those of `joint_covariance`.
    """
    equations, factor = _factorise_graph(graph, poses, landmarks)
    pattern, n = equations.pattern, graph.n_poses
    lower = factor.lower()
    blocks = np.zeros((n + graph.n_landmarks, BLOCK, BLOCK))
    place = np.empty(pattern.size, dtype=np.int64)
    place[lower.p] = np.arange(pattern.size)
    node = np.repeat(np.arange(len(pattern.sizes)), pattern.sizes)[lower.p]
    component = lower.p - pattern.offsets[node]
    for column, rows, values in _selected_inverse_columns(lower, node):
        same = node[rows] == node[column]
        a, b = component[rows[same]], component[column]
        blocks[node[column], a, b] = blocks[node[column], b, a] = values[same]
    return blocks[:n], blocks[n:, :POINT, :POINT]


def _selected_inverse_columns(lower: LowerFactor, node: Indices) -> list[tuple[int, Indices, Floats]]:
    """(17): for each column of Z, its rows (the column itself first) and their values; `node` (s,) owns each column.

    A column keeps Z over its rows, the front, until the columns whose first row below is this one have taken theirs.
    """
    columns: list[tuple[int, Indices, Floats]] = []
    fronts: dict[int, tuple[Indices, Floats]] = {}
    structure = _inverse_structure(lower, node)
    waiting = np.bincount([rows[0] for rows in structure if len(rows)], minlength=len(structure)).tolist()
    for j in range(len(structure) - 1, -1, -1):
        rows = structure[j]
        front = np.empty((len(rows) + 1, len(rows) + 1))
        below, values = _column_below_diagonal(lower, j)
        column = np.zeros(len(rows))
        column[np.searchsorted(rows, below)] = values
        if len(rows):
            parent = int(rows[0])
            parent_rows, parent_front = fronts[parent]
            at = np.searchsorted(parent_rows, rows)
            front[1:, 1:] = parent_front[np.ix_(at, at)]
            front[0, 1:] = front[1:, 0] = -front[1:, 1:] @ column
            waiting[parent] -= 1
            if not waiting[parent]:
                del fronts[parent]
        front[0, 0] = 1.0 / lower.pivots[j] - column @ front[1:, 0]
        own = np.concatenate([[j], rows])
        columns.append((j, own, front[:, 0].copy()))
        if waiting[j]:
            fronts[j] = own, front
    return columns


def _column_below_diagonal(lower: LowerFactor, j: int) -> tuple[Indices, Floats]:
    """The rows and values of column j of L below its diagonal."""
    span = slice(lower.L.indptr[j], lower.L.indptr[j + 1])
    rows, values = lower.L.indices[span], lower.L.data[span]
    return rows[rows > j].astype(np.int64), values[rows > j]


def _inverse_structure(lower: LowerFactor, node: Indices) -> list[Indices]:
    """The rows P of each column: those of L and of the column's own node, and those that the recursion asks for.

    An entry of L that happens to be zero may have been left out of it: its place is needed all the same.
    """
    owned: dict[int, list[int]] = {}
    for position, owner in enumerate(node.tolist()):
        owned.setdefault(owner, []).append(position)
    structure = []
    for j, owner in enumerate(node.tolist()):
        mates = np.array([position for position in owned[owner] if position > j], dtype=np.int64)
        structure.append(np.union1d(_column_below_diagonal(lower, j)[0], mates))
    for rows in structure:
        if len(rows) > 1:
            structure[rows[0]] = np.union1d(structure[rows[0]], rows[1:])
    return structure


def _factorise_graph(
    graph: PoseGraph, poses: ArrayLike, landmarks: ArrayLike | None
) -> tuple[NormalEquations, Factorisation]:
    equations = NormalEquations(graph)
    upper = equations.upper_triangle(
        equations.join_state(copy_checked_poses(graph, poses), copy_checked_landmarks(graph, landmarks))
    )
    factor = factorise(upper)
    if not is_positive_definite(upper, factor.lower()):
        raise SingularSystemError("the information of the graph is singular: some unknown is free")
    return equations, factor


def _unknowns_of_nodes(equations: NormalEquations, nodes: Sequence[int]) -> Indices:
    """The unknowns of nodes, one after the other; `size` for those of fixed poses."""
    graph = equations.graph
    outside = [k for k in nodes if not 0 <= k < graph.n_poses + graph.n_landmarks]
    if outside:
        raise NodeIndexError("nodes", f"node {outside[0]} does not exist")
    chosen = np.asarray(nodes, dtype=np.int64)
    dimensions = np.where(chosen < graph.n_poses, BLOCK, POINT)
    return equations.pattern.unknowns_of_nodes(chosen).T[np.arange(BLOCK) < dimensions[:, None]]
