"""Learning the beam model from ranges and what the map predicted, by expectation-maximisation.

Each round asks which cause each range had, in probability, given the present model (E); then takes the shares, the
sigma and the rate that explain the ranges best, weighted so (M). The likelihood never decreases.

Sources: Dempster, Laird, Rubin, "Maximum Likelihood from Incomplete Data via the EM Algorithm" (1977); Thrun, Burgard,
Fox, "Probabilistic Robotics" (2005), table 6.2. There sigma and rate have closed forms because the truncation of both
laws is overlooked; here the truncated laws themselves are climbed, which is what keeps the likelihood from falling
("generalised" EM: the M step improves, a round after the other, instead of finding the very top each time).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.sensors.beam import BeamModel, log_hit

Floats = NDArray[np.float64]

# Steps of the logarithms of sigma and rate: to measure slopes, and the greatest in one round.
_STEP, _REACH = 1e-3, 0.7
# A cause to which fewer ranges than this are due says nothing about its parameter.
_WITNESSES = 1e-3


@dataclass(frozen=True, eq=False)
class BeamFit:
    """The model learned, the log likelihood before each round and after the last one, and whether they settled."""

    model: BeamModel
    log_likelihoods: Floats
    converged: bool


def learn_beam_model(
    ranges: ArrayLike, expected: ArrayLike, start: BeamModel, *, rounds: int = 200, tolerance: float = 1e-7
) -> BeamFit:
    """The model that makes ranges (n,) most likely given expected ones (n,), near `start`.

    Stops when a round gains less than `tolerance` a range. A share that is zero at the start stays zero. Raises
    InvalidArgumentError, also when a range is impossible under `start`.
    """
    z, truth = np.asarray(ranges, dtype=np.float64), np.asarray(expected, dtype=np.float64)
    if z.ndim != 1 or z.size == 0 or truth.shape != z.shape:
        raise InvalidArgumentError(
            "ranges", f"of shape {z.shape} and expected {truth.shape} are not pairs, one or more"
        )
    model, history = start, [_total_log_likelihood(start, z, truth)]
    if not np.isfinite(history[0]):
        raise InvalidArgumentError("start", "makes some range impossible")
    for _ in range(rounds):
        model = _maximisation_step(model, z, truth, responsibilities(model, z, truth))
        history.append(_total_log_likelihood(model, z, truth))
        if history[-1] - history[-2] < tolerance * z.size:
            return BeamFit(model, np.array(history), True)
    return BeamFit(model, np.array(history), False)


def responsibilities(model: BeamModel, ranges: Floats, expected: Floats) -> Floats:
    """The probability (4, n) of each cause of each range."""
    joint = model.shares[:, None] * model.cause_densities(ranges, expected)
    return np.asarray(joint / joint.sum(axis=0))


def _maximisation_step(model: BeamModel, z: Floats, truth: Floats, due: Floats) -> BeamModel:
    """The M step."""
    hit, short, beyond, random = (float(share) for share in due.mean(axis=1) / due.mean(axis=1).sum())
    return replace(
        model,
        hit=hit,
        short=short,
        beyond=beyond,
        random=random,
        sigma=_newton_step_in_log(
            model.sigma, lambda sigma: _weighted_sum(due[0], log_hit(z, truth, sigma, model.max_range)), due[0]
        ),
        rate=_newton_step_in_log(
            model.rate, lambda rate: _weighted_sum(due[1], _log_short_density(z, truth, rate)), due[1]
        ),
    )


def _newton_step_in_log(present: float, gain: Callable[[float], float], due: Floats) -> float:
    """The top of the parabola through three gains, in the logarithm of a parameter: a step of Newton's method.

    The present value is kept when the step gains nothing, so that a round of EM never loses.
    """
    if due.sum() < _WITNESSES:
        return present
    lower, here, upper = (gain(present * np.exp(step)) for step in (-_STEP, 0.0, _STEP))
    slope, curvature = (upper - lower) / 2.0, upper - 2.0 * here + lower
    steps = -slope / curvature if curvature < 0.0 else np.sign(slope) * np.inf
    candidate = present * float(np.exp(np.clip(steps * _STEP, -_REACH, _REACH)))
    return candidate if gain(candidate) > here else present


def _log_short_density(z: Floats, truth: Floats, rate: float) -> Floats:
    """The logarithm of the truncated exponential; what is due to it has 0 <= z <= truth, truth > 0."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.log(rate) - rate * z - np.log(-np.expm1(-rate * truth)))


def _weighted_sum(due: Floats, logs: Floats) -> float:
    """Sum of due x logs over what is due at all: where nothing is, a logarithm may be infinite."""
    some = due > 0.0
    return float(due[some] @ logs[some])


def _total_log_likelihood(model: BeamModel, z: Floats, truth: Floats) -> float:
    return float(np.sum(model.log_density(z, truth)))
