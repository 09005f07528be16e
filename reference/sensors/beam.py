"""The beam model: a range is a hit, something unexpected on the way, a reading at full range, or noise.

    p(z | z*) = hit p_hit + short p_short + beyond p_beyond + random p_random                                  (1)

z* is the range that the map predicts. Readings at `max_range` are events of positive probability, shorter ones have a
density: (1) is a density with respect to length on [0, max_range[ plus a unit mass at max_range, and its total is one.

Source: Thrun, Burgard, Fox, "Probabilistic Robotics" (2005), section 6.3.1. One refinement: what the Gaussian of a hit
puts beyond `max_range` is read as `max_range`, instead of being cut off; and where nothing is within reach the hit is
that reading for sure.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import log_ndtr, ndtr, ndtri

from reference.errors import InvalidArgumentError
from reference.sensors.rays import check_poses, check_power
from reference.world.grid_map import GridMap
from reference.world.scan import Scan

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class BeamModel:
    """Shares of the four causes, which sum to one; `sigma` of a hit in metres; `rate` of the unexpected, per metre.

    Raises InvalidArgumentError.
    """

    max_range: float
    hit: float = 0.7
    short: float = 0.1
    beyond: float = 0.1
    random: float = 0.1
    sigma: float = 0.1
    rate: float = 0.5

    def __post_init__(self) -> None:
        for argument in ("max_range", "sigma", "rate"):
            if not 0.0 < getattr(self, argument) < np.inf:
                raise InvalidArgumentError(argument, f"{getattr(self, argument)} is not a positive number")
        if not np.all(self.shares >= 0.0) or not np.isclose(self.shares.sum(), 1.0, atol=1e-9):
            raise InvalidArgumentError("hit, short, beyond, random", "are not shares that sum to one")

    @property
    def shares(self) -> Floats:
        """(hit, short, beyond, random)."""
        return np.array([self.hit, self.short, self.beyond, self.random])

    def cause_densities(self, ranges: ArrayLike, expected: ArrayLike) -> Floats:
        """The densities (4, …) of the four causes, for ranges and expected ranges (…) in [0, max_range].

        p_hit(z)    = N(z; z*, sigma^2) / Phi(z* / sigma)                  and what lies beyond, at max_range  (2)
        p_short(z)  = rate exp(-rate z) / (1 - exp(-rate z*))              for z <= z*, z* > 0                 (3)
        p_beyond(z) = 1 at max_range
        p_random(z) = 1 / max_range                                        below max_range

        Inside a wall, z* = 0, there is no way for something to be on: p_short is zero. Raises InvalidArgumentError.
        """
        z, truth = np.broadcast_arrays(
            self._check_in_range("ranges", ranges), self._check_in_range("expected", expected)
        )
        full = z >= self.max_range
        short = np.zeros(z.shape)
        reachable = (z <= truth) & (truth > 0.0) & ~full
        np.divide(self.rate * np.exp(-self.rate * z), -np.expm1(-self.rate * truth), out=short, where=reachable)
        hit = np.exp(log_hit(z, truth, self.sigma, self.max_range))
        return np.stack([hit, short, full.astype(np.float64), np.where(full, 0.0, 1.0 / self.max_range)])

    def log_density(self, ranges: ArrayLike, expected: ArrayLike) -> Floats:
        """log of (1), (…), -inf where the model says never. Raises InvalidArgumentError."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.log(np.tensordot(self.shares, self.cause_densities(ranges, expected), axes=1)))

    def sample(self, expected: ArrayLike, rng: np.random.Generator) -> Floats:
        """One range for each expected range (n,), drawn from (1). Raises InvalidArgumentError."""
        truth = np.atleast_1d(self._check_in_range("expected", expected))
        cause = rng.choice(4, size=truth.shape, p=self.shares / self.shares.sum())
        u = rng.random(truth.shape)
        below_zero = ndtr(-truth / self.sigma)
        hits = np.clip(truth + self.sigma * ndtri(below_zero + u * (1.0 - below_zero)), 0.0, self.max_range)
        hits[truth >= self.max_range] = self.max_range
        shorts = np.minimum(-np.log1p(u * np.expm1(-self.rate * truth)) / self.rate, truth)
        return np.choose(cause, [hits, shorts, np.full(truth.shape, self.max_range), u * self.max_range])

    def _check_in_range(self, argument: str, lengths: ArrayLike) -> Floats:
        values = np.asarray(lengths, dtype=np.float64)
        if not np.all((values >= 0.0) & (values <= self.max_range)):
            raise InvalidArgumentError(argument, "are not all lengths in [0, max_range]")
        return values


def log_hit(ranges: Floats, expected: Floats, sigma: float, max_range: float) -> Floats:
    """The logarithm of (2), (…)."""
    away = (ranges - expected) / sigma
    inside = -0.5 * away**2 - np.log(sigma * np.sqrt(2.0 * np.pi))
    density = np.where(ranges >= max_range, log_ndtr(-away), inside) - log_ndtr(expected / sigma)
    return np.where(expected < max_range, density, np.where(ranges >= max_range, 0.0, -np.inf))


def plain_densities(model: BeamModel, ranges: ArrayLike, expected: ArrayLike) -> Floats:
    """The four causes (4, n) as they are first written, neither cut off nor normalised.

        N(z; z*, sigma^2),  rate exp(-rate z) [z <= z*],  [z >= max_range],  1 / max_range                     (4)

    Not quite densities: the hit and the short overflow [0, max_range]. `ranges` and `expected` (n,) are lengths in
    [0, max_range]. Raises InvalidArgumentError.
    """
    z, truth = np.asarray(ranges, dtype=np.float64), np.asarray(expected, dtype=np.float64)
    if z.ndim != 1 or z.shape != truth.shape:
        raise InvalidArgumentError("ranges", f"of shape {z.shape} do not go with expected ones of shape {truth.shape}")
    if np.any(np.isnan(z)) or np.any(np.isnan(truth)):
        raise InvalidArgumentError("ranges", "hold a NaN: a beam that was not measured has no density")
    return np.stack(
        [
            np.exp(-0.5 * ((z - truth) / model.sigma) ** 2) / (model.sigma * np.sqrt(2.0 * np.pi)),
            np.where(z <= truth, model.rate * np.exp(-model.rate * z), 0.0),
            np.where(z >= model.max_range, 1.0, 0.0),
            np.full(z.shape, 1.0 / model.max_range),
        ]
    )


def plain_log_likelihood(
    ranges: ArrayLike, expected: ArrayLike, sigma: float, max_range: float, shares: ArrayLike, rate: float
) -> float:
    """The sum over beams of the log of the mixture of (4).

    `shares` (4,) are (hit, short, beyond, random). Raises InvalidArgumentError.
    """
    hit, short, beyond, random = np.asarray(shares, dtype=np.float64).tolist()
    model = BeamModel(max_range, hit, short, beyond, random, sigma, rate)
    with np.errstate(divide="ignore"):
        return float(np.sum(np.log(model.shares @ plain_densities(model, ranges, expected))))


class BeamSensor:
    """A ScanLikelihood: rays are cast from every pose in the map, and beams compared by the beam model, independently.

    `power` tempers the product of the beams. Raises InvalidArgumentError.
    """

    def __init__(self, grid_map: GridMap, model: BeamModel, power: float = 1.0) -> None:
        self.grid_map, self.model, self.power = grid_map, model, check_power(power)

    def log_likelihood(self, poses_world: Floats, scan: Scan) -> Floats:
        """power x sum over the measured beams k of log p(z_k | z*_k), (n,); 0 where none is. InvalidArgumentError."""
        poses, seen = check_poses(poses_world, scan), scan.only_measured()
        if not len(seen):
            return np.zeros(len(poses))
        # What met nothing as far as its own lidar sees is no hit at that distance.
        longest = min(self.model.max_range, seen.max_range)
        model = self.model if longest == self.model.max_range else replace(self.model, max_range=longest)
        expected = np.minimum(self.grid_map.cast_scans(poses, seen.angles, longest), longest)
        beams = model.log_density(np.minimum(seen.ranges, longest)[None, :], expected)
        return np.asarray(self.power * beams.sum(axis=1))
