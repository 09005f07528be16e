"""Data association: which landmark each measurement is of, when no label says it.

One scan gives m measurements, and the map has l landmarks, whose expected measurements err together: the robot's own
error is in all of them. Each measurement alone may be compatible with several landmarks; the nearest one, in the metric
of its innovation, is the plain answer. It is wrong where the robot's heading is off by more than landmarks are apart,
and wrong for all measurements at once. Joint compatibility asks that they agree about one and the same error.

Sources: Bar-Shalom, Fortmann, "Tracking and Data Association" (1988), for gates and nearest neighbours; Neira, Tardós,
"Data Association in Stochastic Mapping Using the Joint Compatibility Test" (2001), for JCBB.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import solve_triangular
from scipy.special import gammaincinv

from reference.ekf_slam import EkfSlam
from reference.errors import InvalidArgumentError
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

SPURIOUS = -1
SIZE = 2
CONFIDENCE = 0.99


class AssociationError(InvalidArgumentError):
    """Expected sightings or measurements that cannot be compared; `argument` names them."""


@dataclass(frozen=True, eq=False)
class ExpectedSightings:
    """The l landmarks as they should be seen: `means` (l, 2), their joint `covariance` (2 l, 2 l), without noise.

    `noise` (2, 2): that of one measurement, independent from one to the next. `angles` (2,): which of both components
    are angles in radians. Raises AssociationError.
    """

    means: Floats
    covariance: Floats
    noise: Floats
    angles: tuple[bool, bool] = (False, True)

    def __post_init__(self) -> None:
        means = np.asarray(self.means, dtype=np.float64).reshape(-1, SIZE)
        size = means.size
        for name, shape in (("covariance", (size, size)), ("noise", (SIZE, SIZE))):
            values = np.asarray(getattr(self, name), dtype=np.float64)
            if values.shape != shape or not np.all(np.isfinite(values)) or not np.allclose(values, values.T):
                raise AssociationError(name, f"of shape {values.shape} is not a covariance {shape}")
            object.__setattr__(self, name, values)
        if not np.all(np.isfinite(means)):
            raise AssociationError("means", "are not finite")
        object.__setattr__(self, "means", means)

    @classmethod
    def from_slam(cls, belief: EkfSlam) -> tuple[ExpectedSightings, list[int]]:
        """What the robot of an EKF-SLAM expects of its landmarks, and their identities, in the same order."""
        identities = sorted(belief.slots)
        means, jacobian = np.zeros((len(identities), SIZE)), np.zeros((SIZE * len(identities), belief.mean.size))
        for k, identity in enumerate(identities):
            seen = belief.predict_sighting(belief.slots[identity], np.zeros(SIZE))
            means[k] = -seen.innovation.difference
            jacobian[SIZE * k : SIZE * k + SIZE, seen.columns] = seen.H
        return cls(means, jacobian @ belief.covariance @ jacobian.T, belief.noise.sighting_covariance), identities

    def __len__(self) -> int:
        return len(self.means)

    def measurement_differences(self, measurements: ArrayLike) -> Floats:
        """What was measured, (m, 2), less what was expected: (m, l, 2). Raises AssociationError."""
        z = np.asarray(measurements, dtype=np.float64)
        if z.ndim != 2 or z.shape[1] != SIZE or not np.all(np.isfinite(z)):
            raise AssociationError("measurements", f"of shape {z.shape} are not finite numbers (m, {SIZE})")
        away = z[:, None] - self.means
        for component in np.flatnonzero(self.angles):
            away[..., component] = wrap_angle(away[..., component])
        return np.asarray(away)

    def mahalanobis_distances(self, measurements: ArrayLike) -> Floats:
        """The squared Mahalanobis distances (m, l) of each measurement from each landmark, alone.              (1)"""
        away = self.measurement_differences(measurements)
        found = np.empty(away.shape[:2])
        for k in range(len(self)):
            block = slice(SIZE * k, SIZE * k + SIZE)
            S = self.covariance[block, block] + self.noise
            found[:, k] = np.einsum("mi,ij,mj->m", away[:, k], np.linalg.inv(S), away[:, k])
        return found


@dataclass(frozen=True, eq=False)
class Association:
    """`landmarks` (m,): the rank of each measurement's landmark, -1 for none. `distance`: of all pairs together, by
    their joint innovation; `explored_nodes`: the hypotheses that were looked at."""

    landmarks: Integers
    distance: float
    explored_nodes: int

    @cached_property
    def pairs(self) -> list[tuple[int, int]]:
        """(measurement, landmark) of each pair."""
        return [(int(i), int(self.landmarks[i])) for i in np.flatnonzero(self.landmarks != SPURIOUS)]


def joint_distance(expected: ExpectedSightings, measurements: ArrayLike, landmarks: ArrayLike) -> float:
    """The squared Mahalanobis distance of all pairs together: h' C^-1 h, with C the joint covariance of innovations.

    C holds the covariances between the expectations of the landmarks, which (1) forgets. 0 without a pair.
    """
    chosen = np.asarray(landmarks, dtype=np.int64)
    paired = np.flatnonzero(chosen != SPURIOUS)
    if not len(paired):
        return 0.0
    away = expected.measurement_differences(measurements)[paired, chosen[paired]].ravel()
    columns = (SIZE * chosen[paired][:, None] + np.arange(SIZE)).ravel()
    C = expected.covariance[np.ix_(columns, columns)] + np.kron(np.eye(len(paired)), expected.noise)
    return float(away @ np.linalg.solve(C, away))


def nearest_neighbours(
    expected: ExpectedSightings, measurements: ArrayLike, confidence: float = CONFIDENCE
) -> Association:
    """Pairs of least distance (1) first, each landmark and each measurement once, as long as they pass their gate.

    The gate is the quantile `confidence` of chi-square with 2 degrees: of true pairs it loses 1 - `confidence`. Raises
    AssociationError.
    """
    distances, gate = expected.mahalanobis_distances(measurements), _gate_threshold(confidence, 1)
    found = np.full(len(distances), SPURIOUS)
    free = np.ones(distances.shape, dtype=np.bool_)
    while np.any(free) and np.min(distances, where=free, initial=np.inf) <= gate:
        i, k = np.unravel_index(int(np.argmin(np.where(free, distances, np.inf))), distances.shape)
        found[i] = k
        free[i], free[:, k] = False, False
    return Association(found, joint_distance(expected, measurements, found), distances.size)


def joint_compatibility(
    expected: ExpectedSightings, measurements: ArrayLike, confidence: float = CONFIDENCE
) -> Association:
    """The largest set of pairs that are jointly compatible and, among those as large, the nearest (JCBB).

    Measurement by measurement, each of its compatible landmarks is tried, the nearest first, then none; a branch is cut
    when it can no longer have as many pairs as the best one found. The joint distance of a hypothesis grows with each
    pair, since C is bordered: with L L' = C, one more pair adds a block to L^-1 h, and its square to the distance.

    Raises AssociationError.
    """
    return _CompatibilitySearch(expected, measurements, confidence).run()


@dataclass(eq=False)
class _CompatibilitySearch:
    """Depth first over the measurements; `best` so far."""

    expected: ExpectedSightings
    measurements: ArrayLike
    confidence: float
    explored_nodes: int = 0
    best: Association = field(init=False)

    def run(self) -> Association:
        expected = self.expected
        self._away = expected.measurement_differences(self.measurements)
        distances = expected.mahalanobis_distances(self.measurements)
        self._order = [
            [int(k) for k in np.argsort(row, kind="stable") if row[k] <= _gate_threshold(self.confidence, 1)]
            for row in distances
        ]
        count = len(distances)
        self._gates = [0.0, *(_gate_threshold(self.confidence, pairs) for pairs in range(1, count + 1))]
        # How many of the measurements from i on may still be paired.
        left = np.cumsum([bool(order) for order in self._order][::-1])[::-1] if count else np.zeros(0)
        self._left = [*left.tolist(), 0]
        self.best = Association(np.full(count, SPURIOUS), 0.0, 0)
        self._search_from_measurement(0, [], np.zeros((0, 0)), np.zeros(0))
        return Association(self.best.landmarks, self.best.distance, self.explored_nodes)

    def _search_from_measurement(self, i: int, pairs: list[tuple[int, int]], L: Floats, whitened: Floats) -> None:
        """From measurement i on, with the factor `L` of C and `whitened` = L^-1 h of the `pairs` so far."""
        self.explored_nodes += 1
        distance = float(whitened @ whitened)
        if i == len(self._order):
            more = len(pairs) - len(self.best.pairs)
            if more > 0 or (more == 0 and distance < self.best.distance):
                landmarks = np.full(i, SPURIOUS)
                for measurement, k in pairs:
                    landmarks[measurement] = k
                self.best = Association(landmarks, distance, 0)
            return
        taken = {k for _, k in pairs}
        for k in self._order[i]:
            if k in taken or len(pairs) + self._left[i] < len(self.best.pairs):
                continue
            larger, longer = self._extend_factor(L, whitened, pairs, (i, k))
            if longer @ longer <= self._gates[len(pairs) + 1]:
                self._search_from_measurement(i + 1, [*pairs, (i, k)], larger, longer)
        if len(pairs) + self._left[i + 1] >= len(self.best.pairs):
            self._search_from_measurement(i + 1, pairs, L, whitened)

    def _extend_factor(
        self, L: Floats, whitened: Floats, pairs: list[tuple[int, int]], pair: tuple[int, int]
    ) -> tuple[Floats, Floats]:
        """The factor and the whitened innovations with one more pair."""
        i, k = pair
        own = slice(SIZE * k, SIZE * k + SIZE)
        S = self.expected.covariance[own, own] + self.expected.noise
        size = len(L)
        larger = np.zeros((size + SIZE, size + SIZE))
        larger[:size, :size] = L
        if pairs:
            columns = np.array([SIZE * j + c for _, j in pairs for c in range(SIZE)])
            larger[size:, :size] = solve_triangular(L, self.expected.covariance[columns, own], lower=True).T
        row = larger[size:, :size]
        larger[size:, size:] = np.linalg.cholesky(S - row @ row.T)
        added = solve_triangular(larger[size:, size:], self._away[i, k] - row @ whitened, lower=True)
        return larger, np.append(whitened, added)


def _gate_threshold(confidence: float, pairs: int) -> float:
    if not 0.0 < confidence < 1.0:
        raise AssociationError("confidence", f"{confidence} is not a probability in ]0, 1[")
    return 2.0 * float(gammaincinv(SIZE * pairs / 2.0, confidence))  # of a chi-squared law: half a gamma law's
