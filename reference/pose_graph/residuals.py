"""What edges disagree by: residuals in two conventions, their Jacobians, and chi2.

    chi2(x) = sum over edges of e' omega e,  without a factor 1/2                                          (4)

Source: Grisetti, Kümmerle, Stachniss, Burgard, "A Tutorial on Graph-Based SLAM" (2010), section III, with the error
of an edge taken as the difference of components; where omega is isotropic in translation it gives the same chi2 as
the error t2v(Z^-1 Xi^-1 Xj) of g2o.
"""

from __future__ import annotations

import numpy as np

from reference.pose_graph.graph import BLOCK, POINT, Floats, PoseGraph
from reference.pose_graph.planar import PlanarMatrices
from reference.se2 import wrap_angle


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


def landmark_residuals(T_w_i: Floats, p_w_l: Floats, p_i_l: Floats) -> Floats:
    """Errors (..., 2) of sightings: where the landmark stands in the frame of the pose, less where it was seen.

    e = R(theta_i)' (p_l - t_i) - p_i_l                                                                    (5)
    """
    c, s = np.cos(T_w_i[..., 2]), np.sin(T_w_i[..., 2])
    dx, dy = np.moveaxis(p_w_l - T_w_i[..., :2], -1, 0)
    return np.stack([c * dx + s * dy, -s * dx + c * dy], axis=-1) - p_i_l


def landmark_jacobians(T_w_i: Floats, p_w_l: Floats) -> tuple[Floats, Floats]:
    """Derivatives of (5) with respect to the pose (k, 2, 3) and to the landmark (k, 2, 2): the first rows of (3)."""
    upright = np.column_stack([p_w_l, np.zeros(len(p_w_l))])
    by_i, by_j = jacobians(T_w_i, upright)
    return by_i[:, :POINT], by_j[:, :POINT, :POINT]


def planar_information(graph: PoseGraph) -> PlanarMatrices:
    """The matrices that weigh (1) as those of `graph` weigh the residual of its own convention.

    e2 = P' e1 with P = diag(R(theta_z), 1), by (2), so that e2' omega e2 = e1' (P omega P') e1
    """
    omega = PlanarMatrices.from_matrices(graph.information)
    return omega if graph.convention == "difference" else omega.rotate(np.exp(1j * graph.z_i_j[:, 2]))


def edge_residuals(graph: PoseGraph, poses: Floats) -> Floats:
    """Errors (m, 3) of all edges for poses (n, 3), in the convention of the graph."""
    error = residuals if graph.convention == "difference" else group_residuals
    return error(poses[graph.i], poses[graph.j], graph.z_i_j)


def edge_chi2(graph: PoseGraph, poses: Floats) -> Floats:
    """The share (m,) of each edge in chi2: e' omega e; not finite for poses so far away that it overflows."""
    with np.errstate(over="ignore", invalid="ignore"):
        return _weighted_squares(edge_residuals(graph, poses), graph.information)


def sighting_chi2(graph: PoseGraph, poses: Floats, landmarks: Floats) -> Floats:
    """The share (k,) of each sighting in chi2, for landmarks (l, 2); not finite where it overflows."""
    seen = graph.sightings
    with np.errstate(over="ignore", invalid="ignore"):
        e = landmark_residuals(poses[seen.i], landmarks[seen.landmark], seen.p_i_l)
        return _weighted_squares(e, seen.information)


def chi2(graph: PoseGraph, poses: Floats, landmarks: Floats | None = None) -> float:
    """The sum (4) that is minimised; not finite where it overflows."""
    with np.errstate(over="ignore", invalid="ignore"):
        total = float(edge_chi2(graph, poses).sum())
        return total if landmarks is None else total + float(sighting_chi2(graph, poses, landmarks).sum())


def _weighted_squares(e: Floats, information: Floats) -> Floats:
    weighted = np.matmul(information, e[:, :, None])[:, :, 0]
    return np.asarray((e * weighted).sum(axis=1))
