"""Expectation-maximisation for the beam model as it is first written, where each maximum has a closed form.

    E   r_c(z) = share_c p_c(z) / sum over the causes of the same                                              (1)
    M   share_c = mean of r_c,  sigma^2 = sum r_hit (z - z*)^2 / sum r_hit,  rate = sum r_short / sum r_short z  (2)

The likelihood never decreases. `beam_learning` is the same for the laws cut off at the range of the sensor.

Sources: Dempster, Laird, Rubin, "Maximum Likelihood from Incomplete Data via the EM Algorithm" (1977); Thrun, Burgard,
Fox, "Probabilistic Robotics" (2005), table 6.2.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError
from reference.sensors.beam import BeamModel, plain_densities

Floats = NDArray[np.float64]

# The narrowest hit: ranges that are all alike would make it a spike of infinite likelihood.
NARROWEST = 1e-3
# A cause to which fewer ranges than this are due says nothing about its parameter.
WITNESSES = 1e-9


def plain_responsibilities(model: BeamModel, ranges: ArrayLike, expected: ArrayLike) -> Floats:
    """(1): the probability (4, n) of each cause of each range (n,), given what was expected (n,).

    Raises InvalidArgumentError, also for a range that the model makes impossible.
    """
    joint = model.shares[:, None] * plain_densities(model, ranges, expected)
    total = joint.sum(axis=0)
    if not np.all(total > 0.0):
        raise InvalidArgumentError("model", "makes some range impossible")
    return np.asarray(joint / total)


def plain_em_round(model: BeamModel, ranges: ArrayLike, expected: ArrayLike) -> BeamModel:
    """One round of EM: (1), then (2). Raises InvalidArgumentError."""
    z, truth = np.asarray(ranges, dtype=np.float64), np.asarray(expected, dtype=np.float64)
    due = plain_responsibilities(model, z, truth)
    hit, short, beyond, random = (due.mean(axis=1) / due.mean(axis=1).sum()).tolist()
    sigma, rate = model.sigma, model.rate
    if due[0].sum() > WITNESSES:
        sigma = max(NARROWEST, float(np.sqrt(due[0] @ (z - truth) ** 2 / due[0].sum())))
    if due[1].sum() > WITNESSES and due[1] @ z > 0.0:
        rate = float(due[1].sum() / (due[1] @ z))
    return replace(model, hit=hit, short=short, beyond=beyond, random=random, sigma=sigma, rate=rate)
