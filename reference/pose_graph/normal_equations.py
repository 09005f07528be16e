"""The normal equations of a pose graph, H step = -b, assembled from arrays of components.

The trick that makes them cheap: turned into the world frame, an edge's Jacobian by its second node is the identity.
With D = t_j - t_i and P = diag(R(theta_i), 1), write W = P omega P' and f = P e; then e' omega e = f' W f and

    df/dx_j = I,    df/dx_i = -A,    A = [[1, 0, -D_y], [0, 1, D_x], [0, 0, 1]]                            (7)

    H_jj += W,    H_ij -= A' W,    H_ii += A' W A,    b_j += W f,    b_i -= A' W f                         (8)

which leaves 21 numbers an edge, summed into the upper triangle by one `bincount` over slots known beforehand. In (7)
the derivatives are P times those of e, so that W meets them as omega meets those of e: chi2, its gradient and the
matrix of Gauss-Newton are unchanged. A sighting is an edge to a node without an angle, about which omega says nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from reference.pose_graph.factor import SparsityPattern
from reference.pose_graph.graph import BLOCK, POINT, Floats, Indices, PoseGraph
from reference.pose_graph.planar import Complexes, PlanarMatrices
from reference.pose_graph.residuals import planar_information

Weights = Callable[[Floats], Floats]
TURN = 2.0 * np.pi
UPPER = np.array([(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]).T
WHOLE = np.array([(0, 0), (0, 1), (1, 0), (1, 1), (0, 2), (1, 2), (2, 0), (2, 1), (2, 2)]).T


class EdgeTerms(NamedTuple):
    """What (8) is made of, edge by edge, then sighting by sighting: D, W, and W f as a vector and its part of angle."""

    D: Complexes
    W: PlanarMatrices
    pull: Complexes
    torque: Floats


@dataclass(frozen=True)
class LinearSystem:
    """The shares (m + k,) of edges and sightings in chi2 at a state; H and b there, computed when first asked for."""

    equations: NormalEquations
    terms: EdgeTerms
    shares: Floats

    @property
    def edge_chi2(self) -> Floats:
        """The shares (m,) of the edges."""
        return self.shares[: len(self.equations.graph.i)]

    @property
    def sighting_chi2(self) -> Floats:
        """The shares (k,) of the sightings."""
        return self.shares[len(self.equations.graph.i) :]

    @cached_property
    def chi2(self) -> float:
        return float(self.shares.sum())

    @cached_property
    def upper_entries(self) -> Floats:
        """The entries (nnz,) of the upper triangle of H."""
        return self.equations.upper_entries(self.terms)

    @cached_property
    def b(self) -> Floats:
        """The right-hand side (s,)."""
        return self.equations.right_side(self.terms)


class NormalEquations:
    """H = J' omega J and b = J' omega e over all nodes but the fixed ones; where H is non-zero is worked out once.

    A state is an array (3n + 2l,): the poses x, y, theta one after the other, then the landmarks x, y.
    `free_gauge` leaves no pose out: H is then singular, see gauge.py.
    """

    def __init__(self, graph: PoseGraph, *, free_gauge: bool = False) -> None:
        self.graph = graph
        dimensions = np.repeat([BLOCK, POINT], [graph.n_poses, graph.n_landmarks])
        sizes = dimensions.copy()
        if not free_gauge:
            sizes[list(graph.fixed)] = 0
        self.free = np.flatnonzero(np.repeat(sizes > 0, dimensions))
        self._prepare_measurements()
        self.pattern = SparsityPattern(sizes, self._i, self._j)
        self._slots, self._rows = self._entry_destinations()
        self._numbers = np.empty((len(UPPER[0]) * 2 + len(WHOLE[0]), len(self._i)))

    def _prepare_measurements(self) -> None:
        """The edges, then the sightings: ends, what was measured, and its information in the frame of the first end."""
        graph, seen = self.graph, self.graph.sightings
        self._i, self._j = graph.i, graph.j
        self._z, self._turn = _rows_to_complex(graph.z_i_j), np.ascontiguousarray(graph.z_i_j[:, 2])
        self._omega = planar_information(graph)
        if len(seen.i):
            self._i = np.concatenate([graph.i, seen.i])
            self._j = np.concatenate([graph.j, graph.n_poses + seen.landmark])
            self._z = np.concatenate([self._z, _rows_to_complex(seen.p_i_l)])
            self._turn = np.concatenate([self._turn, np.zeros(len(seen.i))])
            first, second = self._omega, PlanarMatrices.from_matrices(seen.information)
            p, w = np.concatenate([first.p, second.p]), np.concatenate([first.w, second.w])
            self._omega = PlanarMatrices(p, np.concatenate([first.q, second.q]), np.concatenate([first.k, second.k]), w)

    def _entry_destinations(self) -> tuple[Indices, Indices]:
        """Where the numbers of `upper_entries` go in H, and those of `right_side` in b."""
        on, off = self.pattern.diagonal_slots()[*UPPER], self.pattern.off_diagonal_slots()[*WHOLE]
        slots = np.concatenate([on.take(self._j, axis=1), on.take(self._i, axis=1), off])
        return slots.ravel(), self.pattern.unknowns_of_nodes(np.concatenate([self._i, self._j])).ravel()

    def join_state(self, poses: Floats, landmarks: Floats | None = None) -> Floats:
        """The state of poses (n, 3) and landmarks (l, 2)."""
        return np.concatenate([poses.ravel(), [] if landmarks is None else landmarks.ravel()])

    def split_state(self, state: Floats) -> tuple[Floats, Floats]:
        """The poses (n, 3) and landmarks (l, 2) of a state."""
        cut = BLOCK * self.graph.n_poses
        return state[:cut].reshape(-1, BLOCK), state[cut:].reshape(-1, POINT)

    def apply_step(self, state: Floats, step: Floats) -> Floats:
        """The state after a step (s,) of the free unknowns, angles back in [-pi, pi]."""
        there = state.copy()
        there[self.free] += step
        angles = there[2 : BLOCK * self.graph.n_poses : BLOCK]
        angles -= TURN * np.rint(angles / TURN)
        return there

    def assemble(self, state: Floats, weights: Weights | None = None) -> LinearSystem:
        """H and b at a state; `weights` turns the chi2 (m,) of the edges into the factors (m,) that they count with."""
        poses, landmarks = self.split_state(state)
        t, theta, m = _rows_to_complex(poses), poses[:, 2].copy(), len(self.graph.i)
        u = np.empty_like(t)
        u.real, u.imag = np.cos(theta), np.sin(theta)
        if len(landmarks):
            t, theta = (
                np.concatenate([t, _rows_to_complex(landmarks)]),
                np.concatenate([theta, np.zeros(len(landmarks))]),
            )
        D, u_i = t[self._j] - t[self._i], u[self._i]
        f, phi = D - u_i * self._z, theta[self._j] - theta[self._i] - self._turn
        phi -= TURN * np.rint(phi / TURN)
        W = self._omega.rotate(u_i)
        pull, torque = W.multiply(f, phi)
        shares = _dot_products(pull, f) + torque * phi
        if weights is not None:
            factors = np.concatenate([weights(shares[:m]), np.ones(len(shares) - m)])
            W, pull, torque = W.scale(factors), factors * pull, factors * torque
        return LinearSystem(self, EdgeTerms(D, W, pull, torque), shares)

    def upper_triangle(self, state: Floats, weights: Weights | None = None) -> sparse.csc_array:
        """The upper triangle of H (s, s) at a state."""
        return self.pattern.upper_triangle(self.assemble(state, weights).upper_entries)

    def upper_entries(self, terms: EdgeTerms) -> Floats:
        """The upper triangle (nnz,) of H by (8). The angle's row of A' W is W (i D) + (k, w): r, then q2."""
        D, (p, q, k, w) = terms.D, terms.W
        r = 1j * (p * D - q * D.conj()) + k
        q2 = _cross_products(D, k) + w
        H_jj, H_ii, H_ij = self._numbers[:6], self._numbers[6:12], self._numbers[12:]
        np.add(p, q.real, out=H_jj[0])
        H_jj[1] = q.imag
        np.subtract(p, q.real, out=H_jj[2])
        H_jj[3], H_jj[4], H_jj[5] = k.real, k.imag, w
        H_ii[:3] = H_jj[:3]
        H_ii[3], H_ii[4] = r.real, r.imag
        np.add(q2, _cross_products(D, r), out=H_ii[5])
        np.negative(H_jj[:2], out=H_ij[:2])
        np.negative(H_jj[1:5], out=H_ij[2:6])
        np.negative(H_ii[3:5], out=H_ij[6:8])
        np.negative(q2, out=H_ij[8])
        return _sum_by_slot(self._slots, self._numbers.ravel(), self.pattern.nnz)

    def right_side(self, terms: EdgeTerms) -> Floats:
        """b (s,) by (8): - (W f, and its part of angle, turned by D too) for the first node, W f for the second."""
        D, _, pull, torque = terms
        sides = np.empty((BLOCK, 2, len(D)))
        sides[0, 1], sides[1, 1], sides[2, 1] = pull.real, pull.imag, torque
        np.negative(sides[:2, 1], out=sides[:2, 0])
        np.subtract(-torque, _cross_products(D, pull), out=sides[2, 0])
        return _sum_by_slot(self._rows, sides.ravel(), self.pattern.size)


def _rows_to_complex(rows: Floats) -> Complexes:
    """x + i y (n,) of rows that begin with x and y."""
    return np.ascontiguousarray(rows[:, :2]).view(np.complex128)[:, 0]


def _dot_products(a: Complexes, b: Complexes) -> Floats:
    return (a.conj() * b).real


def _cross_products(a: Complexes, b: Complexes) -> Floats:
    return (a.conj() * b).imag


def _sum_by_slot(slots: Indices, values: Floats, size: int) -> Floats:
    """The sum (size,) of the values that fall in each slot; what falls in the slot `size` is left out."""
    return np.asarray(np.bincount(slots, values, minlength=size + 1), dtype=np.float64)[:-1]
