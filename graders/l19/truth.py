"""What is right in module L19, from `reference`: one prediction, one correction, of a belief and of a linear sensor."""

from __future__ import annotations

import numpy as np

from graders.core.contract.values import Floats
from reference.filters.kalman import KalmanFilter
from reference.filters.models import LinearGaussian

Belief = tuple[Floats, Floats]
"""A mean (n,) and a covariance (n, n)."""


def predicted(x: Floats, P: Floats, F: Floats, Q: Floats, shift: Floats | None = None) -> Belief:
    """The belief after x <- F x + shift + w, w ~ N(0, Q); `shift` (n,) is zero when it is left out."""
    n = len(x)
    belief = KalmanFilter(LinearGaussian(F, np.eye(n), Q, np.eye(1, n), np.eye(1)), x, P)
    belief.predict(np.zeros(n) if shift is None else shift)
    return belief.mean, belief.covariance


def corrected(x: Floats, P: Floats, z: Floats, H: Floats, R: Floats) -> Belief:
    """The belief once z = H x + v is seen, v ~ N(0, R): z (m,), H (m, n), R (m, m)."""
    n = len(x)
    belief = KalmanFilter(LinearGaussian(np.eye(n), np.eye(n), np.zeros((n, n)), H, R), x, P)
    belief.correct(z)
    return belief.mean, belief.covariance


def moved(m: float, v: float, u: float, q: float) -> tuple[float, float]:
    """The same on a line: mean and variance after a displacement u, uncertain by the variance q."""
    return _numbers(predicted(np.array([m]), np.array([[v]]), np.eye(1), np.array([[q]]), np.array([u])))


def seen(m: float, v: float, z: float, r: float) -> tuple[float, float]:
    """The same on a line: mean and variance once z is read, of variance r."""
    return _numbers(corrected(np.array([m]), np.array([[v]]), np.array([z]), np.eye(1), np.array([[r]])))


def _numbers(belief: Belief) -> tuple[float, float]:
    mean, covariance = belief
    return float(mean.item()), float(covariance.item())
