"""The normal equations of a pose graph, H step = -b, assembled from arrays of components.

The trick that makes them cheap: turned into the world frame, an edge's Jacobian by its second node is the identity.
With D = t_j - t_i and P = diag(R(theta_i), 1), write W = P omega P' and f = P e; then e' omega e = f' W f and

    df/dx_j = I,    df/dx_i = -A,    A = [[1, 0, -D_y], [0, 1, D_x], [0, 0, 1]]                            (7)

    H_jj += W,    H_ij -= A' W,    H_ii += A' W A,    b_j += W f,    b_i -= A' W f                         (8)

which leaves 21 numbers an edge, summed into the upper triangle by one `bincount` over slots known beforehand. A
sighting is the same without the third row: 15 numbers. In (7) the derivatives are P times those of e, so that W meets
them as omega meets those of e: chi2, its gradient and the matrix of Gauss-Newton are unchanged.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import sparse

from reference.pose_graph.factor import Pattern
from reference.pose_graph.graph import BLOCK, POINT, Floats, Indices, PoseGraph
from reference.pose_graph.residuals import turned_information

Weights = Callable[[Floats], Floats]
TURN = 2.0 * np.pi
UPPER = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@dataclass(frozen=True)
class System:
    """H as the entries `data` (nnz,) of its upper triangle, b (s,), and the chi2 (m,), (k,) of the edges there."""

    data: Floats
    b: Floats
    edge_chi2: Floats
    sighting_chi2: Floats

    @property
    def chi2(self) -> float:
        return float(self.edge_chi2.sum() + self.sighting_chi2.sum())


class Ends(NamedTuple):
    """Where in the state the components of the ends of the edges stand."""

    xi: Indices
    yi: Indices
    theta_i: Indices
    xj: Indices
    yj: Indices
    theta_j: Indices


class NormalEquations:
    """H = J' omega J and b = J' omega e over all nodes but the fixed ones; where H is non-zero is worked out once.

    A state is an array (3n + 2l,): the poses x, y, theta one after the other, then the landmarks x, y.
    `free_gauge` leaves no pose out: H is then singular, see gauge.py.
    """

    def __init__(self, graph: PoseGraph, *, free_gauge: bool = False) -> None:
        seen, n = graph.sightings, graph.n_poses
        self.graph = graph
        sizes = np.concatenate([np.full(n, BLOCK), np.full(graph.n_landmarks, POINT)])
        if not free_gauge:
            sizes[list(graph.fixed)] = 0
        first = np.concatenate([graph.i, seen.i])
        second = np.concatenate([graph.j, seen.landmark + n])
        self.pattern = Pattern(sizes, first, second)
        self._edges = _ends(BLOCK * graph.i, BLOCK * graph.j)
        self._sightings = _ends(BLOCK * seen.i, BLOCK * n + POINT * seen.landmark)
        turned = turned_information(graph)
        self._weights = tuple(np.ascontiguousarray(turned[:, a, b]) for a, b in UPPER)
        self._z = tuple(np.ascontiguousarray(column) for column in graph.z_i_j.T)
        self._seen_at = tuple(np.ascontiguousarray(column) for column in seen.p_i_l.T)
        self._seen_weights = tuple(np.ascontiguousarray(seen.information[:, a, b]) for a, b in ((0, 0), (0, 1), (1, 1)))
        self._slots, self._rows = self._destinations(len(graph.i))
        free = np.repeat(sizes > 0, np.concatenate([np.full(n, BLOCK), np.full(graph.n_landmarks, POINT)]))
        self.free = np.flatnonzero(free)

    def _destinations(self, m: int) -> tuple[Indices, Indices]:
        """Where the numbers of `_edge_terms`, then of `_sighting_terms`, go in H and in b."""
        graph, pattern, n = self.graph, self.pattern, self.graph.n_poses
        i, j, pose, landmark = graph.i, graph.j, graph.sightings.i, graph.sightings.landmark + n
        off = [[pattern.off_diagonal(a, b) for b in range(BLOCK)] for a in range(BLOCK)]
        on = {(a, b): pattern.diagonal(a, b) for a, b in UPPER}
        slots = [on[at][j] for at in UPPER] + [on[at][i] for at in UPPER]
        slots += [off[a][b][:m] for a in range(BLOCK) for b in range(BLOCK)]
        rows = [pattern.unknowns(i, a) for a in range(BLOCK)] + [pattern.unknowns(j, a) for a in range(BLOCK)]
        if len(pose):
            slots += [on[at][landmark] for at in ((0, 0), (0, 1), (1, 1))] + [on[at][pose] for at in UPPER]
            slots += [off[a][b][m:] for a in range(BLOCK) for b in range(POINT)]
            rows += [pattern.unknowns(pose, a) for a in range(BLOCK)]
            rows += [pattern.unknowns(landmark, a) for a in range(POINT)]
        return np.concatenate(slots), np.concatenate(rows)

    def state(self, poses: Floats, landmarks: Floats | None = None) -> Floats:
        """The state of poses (n, 3) and landmarks (l, 2)."""
        return np.concatenate([poses.ravel(), [] if landmarks is None else landmarks.ravel()])

    def nodes(self, state: Floats) -> tuple[Floats, Floats]:
        """The poses (n, 3) and landmarks (l, 2) of a state."""
        cut = BLOCK * self.graph.n_poses
        return state[:cut].reshape(-1, BLOCK), state[cut:].reshape(-1, POINT)

    def moved(self, state: Floats, step: Floats) -> Floats:
        """The state after a step (s,) of the free unknowns, angles back in [-pi, pi]."""
        there = state.copy()
        there[self.free] += step
        angles = there[2 : BLOCK * self.graph.n_poses : BLOCK]
        angles -= TURN * np.rint(angles / TURN)
        return there

    def assemble(self, state: Floats, weights: Weights | None = None) -> System:
        """H and b at a state; `weights` turns the chi2 (m,) of the edges into the factors (m,) that they count with."""
        blocks, sides, edges = self._edge_terms(state, weights)
        seen_blocks, seen_sides, sightings = self._sighting_terms(state)
        if len(sightings):
            blocks, sides = np.concatenate([blocks, seen_blocks]), np.concatenate([sides, seen_sides])
        data = _sums(self._slots, blocks, self.pattern.nnz)
        b = _sums(self._rows, sides, self.pattern.size)
        return System(data, b, edges, sightings)

    def upper(self, state: Floats, weights: Weights | None = None) -> sparse.csc_array:
        """The upper triangle of H (s, s) at a state."""
        return self.pattern.upper(self.assemble(state, weights).data)

    def _edge_terms(self, state: Floats, weights: Weights | None) -> tuple[Floats, Floats, Floats]:
        """(8) for the edges: 21 numbers for H, 6 for b, in the order of `_destinations`; and their chi2 (m,)."""
        at, (zx, zy, zt), (w00, w01, w02, w11, w12, W22) = self._edges, self._z, self._weights
        theta = state[at.theta_i]
        c, s = np.cos(theta), np.sin(theta)
        dx, dy = state[at.xj] - state[at.xi], state[at.yj] - state[at.yi]
        turn = state[at.theta_j] - theta - zt
        f = dx - c * zx + s * zy, dy - s * zx - c * zy, turn - TURN * np.rint(turn / TURN)
        cc, ss, cs = c * c, s * s, c * s
        W00, W11 = cc * w00 - 2.0 * cs * w01 + ss * w11, ss * w00 + 2.0 * cs * w01 + cc * w11
        W01 = cs * (w00 - w11) + (cc - ss) * w01
        W02, W12 = c * w02 - s * w12, s * w02 + c * w12
        v0 = W00 * f[0] + W01 * f[1] + W02 * f[2]
        v1 = W01 * f[0] + W11 * f[1] + W12 * f[2]
        v2 = W02 * f[0] + W12 * f[1] + W22 * f[2]
        shares = v0 * f[0] + v1 * f[1] + v2 * f[2]
        q0, q1, q2 = dx * W01 - dy * W00 + W02, dx * W11 - dy * W01 + W12, dx * W12 - dy * W02 + W22
        H_jj = (W00, W01, W02, W11, W12, W22)
        H_ii = (W00, W01, q0, W11, q1, q2 + dx * q1 - dy * q0)
        H_ij = (-W00, -W01, -W02, -W01, -W11, -W12, -q0, -q1, -q2)
        blocks = np.array(H_jj + H_ii + H_ij)
        sides = np.array((-v0, -v1, dy * v0 - dx * v1 - v2, v0, v1, v2))
        if weights is not None:
            factors = weights(shares)
            blocks *= factors
            sides *= factors
        return blocks.ravel(), sides.ravel(), shares

    def _sighting_terms(self, state: Floats) -> tuple[Floats, Floats, Floats]:
        """(8) for the sightings: 15 numbers for H, 5 for b, in the order of `_destinations`; and their chi2 (k,)."""
        at, (zx, zy), (w00, w01, w11) = self._sightings, self._seen_at, self._seen_weights
        if not len(zx):
            return zx, zx, zx
        c, s = np.cos(state[at.theta_i]), np.sin(state[at.theta_i])
        dx, dy = state[at.xj] - state[at.xi], state[at.yj] - state[at.yi]
        fx, fy = dx - c * zx + s * zy, dy - s * zx - c * zy
        cc, ss, cs = c * c, s * s, c * s
        W00, W11 = cc * w00 - 2.0 * cs * w01 + ss * w11, ss * w00 + 2.0 * cs * w01 + cc * w11
        W01 = cs * (w00 - w11) + (cc - ss) * w01
        v0, v1 = W00 * fx + W01 * fy, W01 * fx + W11 * fy
        q0, q1 = dx * W01 - dy * W00, dx * W11 - dy * W01
        blocks = (W00, W01, W11, W00, W01, q0, W11, q1, dx * q1 - dy * q0, -W00, -W01, -W01, -W11, -q0, -q1)
        sides = (-v0, -v1, dy * v0 - dx * v1, v0, v1)
        return np.concatenate(blocks), np.concatenate(sides), v0 * fx + v1 * fy


def _sums(slots: Indices, values: Floats, size: int) -> Floats:
    """The sum (size,) of the values that fall in each slot; what falls in the slot `size` is left out."""
    return np.asarray(np.bincount(slots, values, minlength=size + 1), dtype=np.float64)[:-1]


def _ends(first: Indices, second: Indices) -> Ends:
    return Ends(first, first + 1, first + 2, second, second + 1, second + 2)
