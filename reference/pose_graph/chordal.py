"""A start for the optimiser that does not depend on odometry: orientations first, then positions, both linear.

Rotations of the plane are complex numbers r of modulus 1. An edge says r_j = r_i exp(i theta_z). Left free of
their modulus, they solve linear least squares:

    minimise  sum of omega_theta |r_j - r_i exp(i theta_z)|^2,  r = exp(i theta) at the fixed poses            (11)

and theta = arg r is near the optimum even where odometry has turned many times too far. With the orientations given,
chi2 is quadratic in the positions: one more linear system, a Gauss-Newton step with the angles held.

Source: Carlone, Tron, Daniilidis, Dellaert, "Initialization Techniques for 3D SLAM" (ICRA 2015), section III-B.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import csgraph

from reference.pose_graph.errors import DisconnectedGraphError, ParameterError, SingularSystemError
from reference.pose_graph.factor import SparsityPattern, factorise, is_positive_definite
from reference.pose_graph.graph import POINT, Floats, PoseGraph, copy_checked_poses
from reference.pose_graph.normal_equations import NormalEquations
from reference.se2 import wrap_angle

SHORTEST = 1e-9


def chordal_initial_guess(graph: PoseGraph, poses: ArrayLike | None = None) -> tuple[Floats, Floats]:
    """Poses (n, 3) and landmarks (l, 2) from the measurements alone; the fixed poses are taken from `poses` (n, 3).

    Without `poses` the fixed pose stands at the origin. Raises DisconnectedGraphError where no edge ties orientations,
    SingularSystemError where a position is not determined, ParameterError where the measurements of orientations cancel
    out, or where several poses are fixed and not given.
    """
    held = _check_held_poses(graph, poses)
    _check_oriented(graph)
    angles = chordal_angles(graph, held[:, 2])
    return solve_positions(graph, np.column_stack([held[:, :2], angles]))


def _check_held_poses(graph: PoseGraph, poses: ArrayLike | None) -> Floats:
    if poses is not None:
        return copy_checked_poses(graph, poses)
    if len(graph.fixed) > 1:
        raise ParameterError("poses", "must be given where several poses are fixed")
    return np.zeros((graph.n_poses, 3))


def _check_oriented(graph: PoseGraph) -> None:
    tied = np.array(graph.fixed[1:], dtype=np.int64)
    tells = graph.information[:, 2, 2] > 0.0
    i = np.concatenate([graph.i[tells], np.full(len(tied), graph.fixed[0])])
    j = np.concatenate([graph.j[tells], tied])
    adjacency = sparse.coo_array((np.ones(len(i)), (i, j)), shape=(graph.n_poses, graph.n_poses))
    _, labels = csgraph.connected_components(adjacency, directed=False)
    lost = np.flatnonzero(labels != labels[graph.fixed[0]])
    if lost.size:
        reason = f"no edge that tells of orientation leads from pose {lost[0]} to pose {graph.fixed[0]}"
        raise DisconnectedGraphError("edges", reason, (int(lost[0]), graph.fixed[0]))


def chordal_angles(graph: PoseGraph, held: Floats) -> Floats:
    """The angles (n,) that solve (11); those of the fixed poses are taken from `held` (n,).

    A complex equation is two real ones: with z = (c, s), r_j - r_i z has the block -[[c, -s], [s, c]] for r_i.
    """
    fixed = list(graph.fixed)
    r = np.zeros((graph.n_poses, POINT))
    r[fixed] = np.column_stack([np.cos(held), np.sin(held)])[fixed]
    sizes = np.full(graph.n_poses, POINT)
    sizes[fixed] = 0
    pattern = SparsityPattern(sizes, graph.i, graph.j)
    if pattern.size:
        weight = graph.information[:, 2, 2]
        c, s = weight * np.cos(graph.z_i_j[:, 2]), weight * np.sin(graph.z_i_j[:, 2])
        data, b = np.zeros(pattern.nnz + 1), np.zeros(pattern.size + 1)
        on, off, rows_i, rows_j = (
            pattern.diagonal_slots(),
            pattern.off_diagonal_slots(),
            *map(pattern.unknowns_of_nodes, (graph.i, graph.j)),
        )
        for row in range(POINT):
            for ends in (graph.i, graph.j):
                np.add.at(data, on[row, row, ends], weight)
        for row, column, term in ((0, 0, -c), (0, 1, -s), (1, 0, s), (1, 1, -c)):
            np.add.at(data, off[row, column], term)
            np.add.at(b, rows_i[row], -term * r[graph.j, column])
            np.add.at(b, rows_j[column], -term * r[graph.i, row])
        # the diagonal blocks hold (0, 1) too, which is zero
        solved = factorise(pattern.upper_triangle(data[:-1])).solve(b[:-1])
        r[sizes > 0] = solved.reshape(-1, POINT)
    lengths = np.hypot(*r.T)
    if np.any(lengths < SHORTEST):
        raise ParameterError("z_i_j", f"the measurements leave pose {np.argmin(lengths)} without an orientation")
    return np.where(sizes > 0, np.arctan2(r[:, 1], r[:, 0]), wrap_angle(held))


def solve_positions(graph: PoseGraph, poses: Floats) -> tuple[Floats, Floats]:
    """The poses (n, 3) and landmarks (l, 2) of least chi2 among those that have the angles of `poses` (n, 3).

    chi2 is quadratic in the positions, so the minimum is one step of Gauss-Newton with the angles' rows left out.
    """
    equations = NormalEquations(graph)
    state = equations.join_state(poses, np.zeros((graph.n_landmarks, POINT)))
    system = equations.assemble(state)
    is_position = (equations.free >= 3 * graph.n_poses) | (equations.free % 3 != 2)
    step = np.zeros(len(equations.free))
    if is_position.any():
        kept = sparse.csc_array(equations.pattern.upper_triangle(system.upper_entries)[is_position][:, is_position])
        factor = factorise(kept)
        if not graph.is_fully_informed and not is_positive_definite(kept, factor.lower()):
            raise SingularSystemError("the positions are not determined: some are free")
        step[is_position] = -factor.solve(system.b[is_position])
    found, landmarks = equations.split_state(equations.apply_step(state, step))
    return np.column_stack([found[:, :2], wrap_angle(found[:, 2])]), landmarks
