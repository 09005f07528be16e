"""What is right in l19/etendu, from the extended filter of `reference`: its pose has a heading that nothing touches."""

from __future__ import annotations

import numpy as np

from graders.core.contract.values import Floats
from graders.l19.truth import Belief
from reference.filters.extended import ExtendedKalmanFilter
from reference.filters.range_bearing import RangeModel


def _model(beacon: Floats, variance: float) -> RangeModel:
    return RangeModel(beacon[None, :], advance_sigma=0.0, turn_sigma=0.0, range_sigma=float(np.sqrt(variance)))


def right_range(x: Floats, beacon: Floats) -> tuple[float, Floats]:
    """The distance, and its derivative (2,) by the position (2,)."""
    model, pose = _model(beacon, 1.0), np.append(x, 0.0)
    return float(model.observe(pose[None, :]).item()), model.observe_jacobian(pose)[0, :2]


def right_correction(x: Floats, P: Floats, z: float, beacon: Floats, r: float) -> Belief:
    spread = np.eye(3)
    spread[:2, :2] = P
    belief = ExtendedKalmanFilter(_model(beacon, r), np.append(x, 0.0), spread)
    belief.correct(np.array([z]))
    return belief.mean[:2], belief.covariance[:2, :2]
