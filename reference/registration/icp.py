"""Iterative closest point: pair every point with the nearest of the other cloud, move, and pair again.

`T_q_p` (x, y, theta) carries coordinates from the frame of P to that of Q. Point-to-point lowers, at each iteration,

    E = sum of rho(min(|R p + t - q(p)|, D)) over the points kept,    q(p) the nearest of Q                  (1)

and cannot raise it (Theorem 4 of the course): a better motion for the same pairs, then better pairs for the same
motion. That still holds with a robust kernel rho, a distance D beyond which a pair is dropped (at the cost of D, or
dropping would pay) and a share of the points kept, the nearest ones: each only caps a cost that falls anyway.
Point-to-line minimises the gaps across the lines of Q instead, in far fewer iterations but without that guarantee.

Sources: Besl and McKay, "A Method for Registration of 3-D Shapes" (1992); Chen and Medioni, "Object Modelling by
Registration of Multiple Range Images" (1992); Chetverikov, Stepanov, Krsek, "Robust Euclidean alignment of 3D point
sets: the trimmed iterative closest point algorithm" (2005).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.registration.acceleration import AndersonExtrapolation
from reference.registration.fits import UNSEEN, WeightedPoints, fit_weighted_pairs, step_towards_lines, transform_points
from reference.registration.kernels import Kernel, LeastSquares
from reference.registration.nearest import Complexes, NearestPoints
from reference.registration.normals import check_plane_cloud
from reference.registration.rigid import InvalidCloudError
from reference.se2 import Pose, rotation_matrix, wrap_angle

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]
Fit = Callable[[Pose, Complexes, Indices, Floats | None], Pose]

IDENTITY = (0.0, 0.0, 0.0)


class IcpError(InvalidArgumentError):
    """Arguments with which clouds cannot be registered; `argument` names the one at fault."""


@dataclass(frozen=True)
class PairingRule:
    """Which pairs count, and how much: a robust kernel, a greatest distance, the share of the points that is kept."""

    kernel: Kernel = field(default_factory=LeastSquares)
    max_distance: float = np.inf
    keep: float = 1.0

    def __post_init__(self) -> None:
        if not self.max_distance > 0.0:
            raise IcpError("max_distance", f"{self.max_distance} is not a positive length")
        if not 0.0 < self.keep <= 1.0:
            raise IcpError("keep", f"{self.keep} is not a share in ]0, 1]")

    @cached_property
    def is_plain(self) -> bool:
        return isinstance(self.kernel, LeastSquares) and self.max_distance == np.inf and self.keep == 1.0

    def cost_and_weights(self, gaps: Floats, distances: Floats) -> tuple[float, Floats | None]:
        """The cost (1) of pairs with gaps (n,), and the weight (n,) of each in the next fit; None: all count alike.

        `distances` (n,): theirs, by which they are rejected; the same as their gaps, but for lines.
        """
        if self.is_plain:
            return float(gaps @ gaps), None
        far = distances > self.max_distance
        costs = self.kernel.cost(np.where(far, self.max_distance, gaps))
        weights = np.where(far, 0.0, self.kernel.weight(gaps))
        if self.keep < 1.0:
            kept = max(1, round(self.keep * len(gaps)))
            order = np.argpartition(distances, kept - 1)
            weights[order[kept:]] = 0.0
            costs = costs[order[:kept]]
        return float(costs.sum()), weights


@dataclass(frozen=True)
class IcpResult:
    """How a registration went.

    `errors` (k + 1,): the cost at the start and after each of the k iterations, every point paired anew. `pairs` (n,):
    the row in Q of the nearest to each point of P, at the end; `gaps` (n,): the distances of these pairs, or across
    lines; `weights` (n,): what each counts, 0 where rejected. `converged`: the last step was below the tolerance.
    """

    T_q_p: Pose
    errors: Floats
    pairs: Indices
    gaps: Floats
    weights: Floats
    converged: bool

    @property
    def R_q_p(self) -> Floats:
        return rotation_matrix(float(self.T_q_p[2]))

    @property
    def t_q_p(self) -> Floats:
        return self.T_q_p[:2]

    @property
    def iterations(self) -> int:
        return len(self.errors) - 1

    @property
    def inliers(self) -> float:
        """The share of the points of P that count."""
        return float(np.mean(self.weights > 0.0))

    @property
    def rmse(self) -> float:
        """The root of the weighted mean of the squared gaps, in the unit of the clouds."""
        return float(np.sqrt(self.weights @ self.gaps**2 / self.weights.sum()))


def icp(
    P: ArrayLike,
    Q: ArrayLike,
    T_q_p: ArrayLike = IDENTITY,
    *,
    pairing: PairingRule | None = None,
    max_iterations: int = 50,
    tolerance: float = 1e-9,
    accelerated: bool = False,
) -> IcpResult:
    """Point-to-point: register P (n, 2) on Q (m, 2), from the guess `T_q_p`. `errors` never increases (Theorem 4).

    Converged when no component of a step exceeds `tolerance`. `accelerated` guesses where the poses are heading and
    jumps there when that is lower: as good an end, in fewer iterations when they creep. Raises IcpError or
    InvalidCloudError, also when every point of P is the same one, or no pair is near enough to count.
    """
    p, q = _check_distinct_points("P", P), _to_complex_points("Q", Q)
    alike = WeightedPoints.from_points(p)

    def fit(T: Pose, moved: Complexes, pairs: Indices, weights: Floats | None) -> Pose:
        return fit_weighted_pairs(
            alike if weights is None else WeightedPoints.from_points(p, weights), q[pairs], weights, T
        )

    def gaps(moved: Complexes, distances: Floats, pairs: Indices) -> Floats:
        return distances

    search = _IcpSearch(p, NearestPoints(q), fit, gaps, pairing or PairingRule(), max_iterations, tolerance)
    return search.run(_check_pose(T_q_p), AndersonExtrapolation(float(np.std(p))) if accelerated else None)


def icp_to_lines(
    P: ArrayLike,
    Q: ArrayLike,
    normals: ArrayLike,
    T_q_p: ArrayLike = IDENTITY,
    *,
    pairing: PairingRule | None = None,
    max_iterations: int = 50,
    tolerance: float = 1e-9,
    unseen: float = UNSEEN,
) -> IcpResult:
    """Point-to-line: as `icp`, with gaps measured along the `normals` (m, 2) of Q, null where Q follows no line.

    Along a motion that no line sees, nothing moves; nor, with a larger `unseen`, along one whose strength, as
    `Observability`'s, is that or less. Raises IcpError or InvalidCloudError.
    """
    p, q, n = _check_distinct_points("P", P), _to_complex_points("Q", Q), _to_complex_points("normals", normals)
    if n.shape != q.shape:
        raise InvalidCloudError("normals", f"{len(n)} of them for {len(q)} points")
    if not np.any(n):
        raise InvalidCloudError("normals", "are all null: Q follows no line")

    def fit(T: Pose, moved: Complexes, pairs: Indices, weights: Floats | None) -> Pose:
        return step_towards_lines(T, moved, q[pairs], n[pairs], np.ones(len(p)) if weights is None else weights, unseen)

    def gaps(moved: Complexes, distances: Floats, pairs: Indices) -> Floats:
        return np.abs((np.conj(n[pairs]) * (moved - q[pairs])).real)

    search = _IcpSearch(p, NearestPoints(q), fit, gaps, pairing or PairingRule(), max_iterations, tolerance)
    return search.run(_check_pose(T_q_p))


class _PairedState(NamedTuple):
    """All points paired at a pose: where they are, their pairs, gaps and weights, and what it all costs."""

    T_q_p: Pose
    moved: Complexes
    pairs: Indices
    gaps: Floats
    cost: float
    weights: Floats | None


def _require_counting_pairs(state: _PairedState) -> _PairedState:
    """The state, in which some pair counts; or IcpError."""
    if state.weights is not None and not state.weights.any():
        raise IcpError("pairing", "no pair is near enough to count")
    return state


@dataclass(frozen=True)
class _IcpSearch:
    """Pairing and fitting in turn; `gaps_of` tells the gaps whose squares `fit` minimises."""

    p: Complexes
    nearest: NearestPoints
    fit: Fit
    gaps_of: Callable[[Complexes, Floats, Indices], Floats]
    pairing: PairingRule
    max_iterations: int
    tolerance: float

    def run(self, T_q_p: Pose, extrapolate: AndersonExtrapolation | None = None) -> IcpResult:
        state, converged = _require_counting_pairs(self._pair_at(T_q_p)), False
        errors = [state.cost]
        while not converged and len(errors) <= self.max_iterations:
            T = self.fit(state.T_q_p, state.moved, state.pairs, state.weights)
            converged = self._has_converged(state.T_q_p, T)
            state = _require_counting_pairs(
                self._try_extrapolation(state, T, extrapolate) if extrapolate and not converged else self._pair_at(T)
            )
            errors.append(state.cost)
        weights = np.ones(len(self.p)) if state.weights is None else state.weights
        return IcpResult(state.T_q_p, np.array(errors), state.pairs, state.gaps, weights, converged)

    def _try_extrapolation(
        self, state: _PairedState, T_fitted: Pose, extrapolate: AndersonExtrapolation
    ) -> _PairedState:
        """Where the sequence is heading, if that is lower than where it is; its next pose otherwise."""
        T = extrapolate(state.T_q_p, T_fitted)
        ahead = self._pair_at(T)
        if ahead.cost <= state.cost:
            return ahead
        extrapolate.forget_older_poses()
        return self._pair_at(T_fitted)

    def _pair_at(self, T: Pose) -> _PairedState:
        moved = transform_points(T, self.p)
        distances, pairs = self.nearest.find(moved)
        gaps = self.gaps_of(moved, distances, pairs)
        cost, weights = self.pairing.cost_and_weights(gaps, distances)
        return _PairedState(T, moved, pairs, gaps, cost, weights)

    def _has_converged(self, T: Pose, T_next: Pose) -> bool:
        dx, dy, turn = (T_next - T).tolist()
        return bool(max(abs(dx), abs(dy), abs(wrap_angle(turn))) <= self.tolerance)


def _to_complex_points(name: str, points: ArrayLike) -> Complexes:
    return check_plane_cloud(name, points).view(np.complex128)[:, 0]


def _check_distinct_points(name: str, points: ArrayLike) -> Complexes:
    cloud = _to_complex_points(name, points)
    if np.all(cloud == cloud[0]):
        raise InvalidCloudError(name, "has no two distinct points: its heading cannot be told")
    return cloud


def _check_pose(guess: ArrayLike) -> Pose:
    T = np.array(guess, dtype=np.float64)
    if T.shape != (3,) or not np.all(np.isfinite(T)):
        raise IcpError("T_q_p", f"of shape {T.shape} is not a finite pose (x, y, theta)")
    return T
