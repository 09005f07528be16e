"""How far an estimated trajectory is from the true one: absolute and relative errors.

Trajectories are arrays of poses: (n, 3) = (x, y, theta) in the plane, or homogeneous matrices (n, d + 1, d + 1) in
dimension d; pose k of the estimate is compared with pose k of the truth. Lengths are in metres, angles in radians.

Sources: Sturm, Engelhard, Endres, Burgard, Cremers, "A Benchmark for the Evaluation of RGB-D SLAM Systems" (2012), for
the two errors; Umeyama, "Least-squares estimation of transformation parameters between two point patterns" (1991), for
the alignment; Kümmerle et al., "On measuring the accuracy of SLAM algorithms" (2009), for relations measured by hand.
The numbers are those of evo, the tool of Michael Grupp that most papers quote.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from reference.errors import InvalidArgumentError, check_choice
from reference.registration import kabsch
from reference.se2 import to_matrix

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Alignment = Literal["none", "first", "rigid", "similarity"]
Unit = Literal["poses", "metres"]


class MetricError(InvalidArgumentError):
    """Trajectories that cannot be compared; `argument` names the one at fault."""


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors (n,), none negative, and what is usually said of them."""

    values: Floats

    @property
    def rmse(self) -> float:
        """The root of the mean square."""
        return float(np.sqrt(np.mean(self.values**2)))

    @property
    def mean(self) -> float:
        return float(np.mean(self.values))

    @property
    def median(self) -> float:
        return float(np.median(self.values))

    @property
    def std(self) -> float:
        """The standard deviation of the errors about their mean, over n."""
        return float(np.std(self.values))

    @property
    def min(self) -> float:
        return float(np.min(self.values))

    @property
    def max(self) -> float:
        return float(np.max(self.values))

    @property
    def squared(self) -> Errors:
        """The squares of the errors: their mean and deviation are quoted beside those of the errors."""
        return Errors(self.values**2)

    @property
    def sse(self) -> float:
        """The sum of squares."""
        return float(np.sum(self.values**2))


@dataclass(frozen=True, eq=False)
class AbsoluteError(Errors):
    """Distances (n,) between true positions and aligned ones: p_truth ~ scale R p_estimate + t.

    `R_truth_estimate` (d, d), `t_truth_estimate` (d,), `scale`; `aligned` (n, d) are the estimated positions there.
    """

    R_truth_estimate: Floats
    t_truth_estimate: Floats
    scale: float
    aligned: Floats


@dataclass(frozen=True, eq=False)
class RelativeError:
    """Errors of the motions between `pairs` (m, 2) of poses: `translation` in metres and `rotation` in radians."""

    pairs: Integers
    translation: Errors
    rotation: Errors


def absolute_trajectory_error(truth: ArrayLike, estimate: ArrayLike, align: Alignment = "rigid") -> AbsoluteError:
    """The ATE: distances between true positions and those of the estimate, once it is laid over the truth.

    `align` is by which transformation: "rigid" or "similarity" (with a scale), those of least squares over all poses;
    "first", which makes the first poses coincide; "none". Raises MetricError, also for any other word.
    """
    check_choice("align", align, Alignment, MetricError)
    true, estimated = _to_matrices("truth", truth), _to_matrices("estimate", estimate)
    _check_comparable(true, estimated)
    R, t, scale = _fit_alignment(true, estimated, align)
    aligned = scale * _positions_of(estimated) @ R.T + t
    return AbsoluteError(np.linalg.norm(_positions_of(true) - aligned, axis=1), R, t, scale, aligned)


def relative_pose_error(
    truth: ArrayLike,
    estimate: ArrayLike,
    delta: float = 1,
    unit: Unit = "poses",
    overlapping: bool = False,
) -> RelativeError:
    """The RPE: how the motions of the estimate differ from the true ones, over `delta` poses or metres.

    For a pair (i, j), with Q the truth and P the estimate,

        E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j),  errors |trans E| and |angle E|                    (Sturm et al., eq. 1)

    Pairs follow one another, each beginning where the last one ends, counted along the estimate; with `overlapping`, of
    poses only, one begins at every pose. Raises MetricError, also when there is no pair, or for any other unit.
    """
    check_choice("unit", unit, Unit, MetricError)
    true, estimated = _to_matrices("truth", truth), _to_matrices("estimate", estimate)
    _check_comparable(true, estimated)
    pairs = _select_pairs(estimated, delta, unit, overlapping)
    if not len(pairs):
        raise MetricError("delta", f"of {delta} {unit} fits in no two of the {len(true)} poses")
    E = _relative_matrices(_motions_between_pairs(true, pairs), _motions_between_pairs(estimated, pairs))
    lengths = np.linalg.norm(_positions_of(E), axis=1)
    return RelativeError(pairs, Errors(lengths), Errors(_rotation_angles(E[:, :-1, :-1])))


def relation_error(poses: ArrayLike, pairs: ArrayLike, T_i_j: ArrayLike) -> RelativeError:
    """The errors of the poses by relations between some of them, which somebody has measured by hand.

    `pairs` (m, 2): which poses; `T_i_j` (m, 3) or (m, d + 1, d + 1): the true pose of the second seen from the first.
    No frame is laid on another: where a map is bent counts there, and not for all that comes after. With Z a relation
    and P the estimate,

        E = Z_ij^-1 (P_i^-1 P_j),  errors |trans E| and |angle E|                        (Kümmerle et al., eq. 3 and 4)

    whose means and deviations are the published figures of Freiburg's benchmark, with or without `squared`. Raises
    MetricError, also where there is no relation.
    """
    estimated, true = _to_matrices("poses", poses), _to_matrices("T_i_j", T_i_j)
    which = np.asarray(pairs)
    if which.shape != (len(true), 2) or which.dtype.kind not in "iu" or true.shape[1:] != estimated.shape[1:]:
        raise MetricError("pairs", f"of shape {which.shape} are not two poses (m, 2) for each of {len(true)} relations")
    if np.any((which < 0) | (which >= len(estimated))):
        raise MetricError("pairs", f"name a pose that is none of the {len(estimated)}")
    E = _relative_matrices(true, _motions_between_pairs(estimated, which))
    return RelativeError(
        which, Errors(np.linalg.norm(_positions_of(E), axis=1)), Errors(_rotation_angles(E[:, :-1, :-1]))
    )


def matching_times(truth: ArrayLike, estimate: ArrayLike, max_difference: float = 0.01) -> Integers:
    """Which poses to compare when two trajectories have times of their own: pairs (m, 2) of indices, increasing.

    `truth` (n,) and `estimate` (k,) are increasing times in seconds. Two are paired when each is the other's nearest,
    no more than `max_difference` apart. Raises MetricError.
    """
    true, estimated = _check_times("truth", truth), _check_times("estimate", estimate)
    if not max_difference >= 0.0:
        raise MetricError("max_difference", f"{max_difference} is not a duration")
    if not true.size or not estimated.size:
        return np.empty((0, 2), dtype=np.int64)
    there = _nearest_indices(true, estimated)
    mutual = np.flatnonzero(_nearest_indices(estimated, true)[there] == np.arange(true.size))
    close = np.abs(true[mutual] - estimated[there[mutual]]) <= max_difference
    return np.column_stack([mutual, there[mutual]])[close]


def _nearest_indices(times: Floats, others: Floats) -> Integers:
    """The index (n,) of the nearest of the increasing `others` to each of `times`; the earlier of two equally near."""
    after = np.clip(np.searchsorted(others, times), 1, max(others.size - 1, 1))
    before = after - 1
    after = np.minimum(after, others.size - 1)
    return np.where(times - others[before] <= others[after] - times, before, after).astype(np.int64)


def _check_times(argument: str, times: ArrayLike) -> Floats:
    values = np.asarray(times, dtype=np.float64)
    if values.ndim != 1 or not np.all(np.isfinite(values)) or np.any(np.diff(values) <= 0.0):
        raise MetricError(argument, f"of shape {values.shape} are not increasing times (n,)")
    return values


def _fit_alignment(true: Floats, estimated: Floats, align: Alignment) -> tuple[Floats, Floats, float]:
    d = true.shape[1] - 1
    if align == "none":
        return np.eye(d), np.zeros(d), 1.0
    if align == "first":
        T = true[0] @ _invert_rigid_matrices(estimated[:1])[0]
        return T[:d, :d], T[:d, d], 1.0
    p, q = _positions_of(estimated), _positions_of(true)
    found = kabsch(p, q)
    if not found.unique:
        raise MetricError("estimate", "can be laid over the truth in several ways: too few poses, or all in line")
    if align == "rigid":
        return found.R_q_p, found.t_q_p, 1.0
    # The best scale, once the rotation is known: sum q.(R p) / sum p.p, centred (Umeyama, eq. 43).
    p_centred, q_centred = p - p.mean(axis=0), q - q.mean(axis=0)
    scale = float(np.sum(q_centred * (p_centred @ found.R_q_p.T)) / np.sum(p_centred**2))
    return found.R_q_p, q.mean(axis=0) - scale * found.R_q_p @ p.mean(axis=0), scale


def _select_pairs(poses: Floats, delta: float, unit: Unit, overlapping: bool) -> Integers:
    n = len(poses)
    if not np.isfinite(delta):
        raise MetricError("delta", f"{delta} is neither a length nor a number of poses")
    if unit == "metres":
        if overlapping or not delta > 0.0:
            raise MetricError("delta", f"of {delta} metres must be positive, and pairs over metres do not overlap")
        return _pair_neighbours(_sample_poses_by_distance(poses, delta))
    if delta != int(delta) or delta < 1:
        raise MetricError("delta", f"{delta} is not a number of poses, one or more")
    step = int(delta)
    if overlapping:
        return np.column_stack([np.arange(n - step), np.arange(step, n)]) if n > step else np.empty((0, 2), np.int64)
    return _pair_neighbours(np.arange(0, n, step))


def _sample_poses_by_distance(poses: Floats, delta: float) -> Integers:
    """Poses, the first one included, each of them the first to lie `delta` metres of path or more after the last."""
    steps = np.linalg.norm(np.diff(_positions_of(poses), axis=0), axis=1).tolist()
    stops, run = [0], 0.0
    for index, step in enumerate(steps, start=1):
        run += step
        if run >= delta:
            stops.append(index)
            run = 0.0
    return np.array(stops)


def _pair_neighbours(stops: Integers) -> Integers:
    return np.column_stack([stops[:-1], stops[1:]])


def _motions_between_pairs(poses: Floats, pairs: Integers) -> Floats:
    return _relative_matrices(poses[pairs[:, 0]], poses[pairs[:, 1]])


def _relative_matrices(first: Floats, second: Floats) -> Floats:
    return np.asarray(_invert_rigid_matrices(first) @ second)


def _invert_rigid_matrices(poses: Floats) -> Floats:
    """The inverses of rigid homogeneous matrices (n, d + 1, d + 1): [R^T | -R^T t]."""
    d = poses.shape[1] - 1
    turned = poses[:, :d, :d].transpose(0, 2, 1)
    found = np.tile(np.eye(d + 1), (len(poses), 1, 1))
    found[:, :d, :d] = turned
    found[:, :d, d:] = -turned @ poses[:, :d, d:]
    return found


def _rotation_angles(R: Floats) -> Floats:
    """The angles (n,) of rotations (n, d, d), d = 2 or 3, in [0, pi]; rounded ones count as the nearest rotation."""
    if R.shape[1] == 2:
        return np.asarray(np.abs(np.arctan2(R[:, 1, 0] - R[:, 0, 1], R[:, 0, 0] + R[:, 1, 1])))
    return np.asarray(Rotation.from_matrix(R).magnitude(), dtype=np.float64)


def _positions_of(poses: Floats) -> Floats:
    return np.asarray(poses[:, :-1, -1])


def _to_matrices(argument: str, trajectory: ArrayLike) -> Floats:
    poses = np.asarray(trajectory, dtype=np.float64)
    planar = poses.ndim == 2 and poses.shape[1] == 3
    if not planar and (poses.ndim != 3 or poses.shape[1:] not in ((3, 3), (4, 4))):
        raise MetricError(argument, f"of shape {poses.shape} is no trajectory: (n, 3), (n, 3, 3) or (n, 4, 4)")
    if not len(poses) or not np.all(np.isfinite(poses)):
        raise MetricError(argument, "is empty, or holds a number that is not finite")
    return to_matrix(poses) if planar else poses


def _check_comparable(true: Floats, estimated: Floats) -> None:
    if true.shape != estimated.shape:
        raise MetricError("estimate", f"has {estimated.shape} as matrices, the truth {true.shape}")
