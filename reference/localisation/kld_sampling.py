"""KLD-sampling: as many particles as the belief needs, and no more.

If n independent draws from a distribution fill k bins, then with probability 1 - delta the Kullback-Leibler divergence
between their histogram and the truth is below epsilon as soon as

    n >= chi2_{k - 1, 1 - delta} / (2 epsilon)                                                                 (1)

because 2 n times the divergence follows that law, in the limit of many draws: for few, the promise is kept nearly.

Source: Fox, "Adapting the Sample Size in Particle Filters Through KLD-Sampling", IJRR 22 (2003), equations 11 and 13.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ndtri

from reference.errors import InvalidArgumentError
from reference.se2 import wrap_angle

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class KldSampling:
    """How close the particles must be to the belief that they stand for.

    `epsilon`: the divergence allowed, in nats; `delta`: how often it may be exceeded; `cell` in metres and `sector` in
    radians: the bins; `least`, `most`: bounds on the number of particles. Raises InvalidArgumentError.
    """

    epsilon: float = 0.05
    delta: float = 0.01
    cell: float = 0.5
    sector: float = np.deg2rad(10.0)
    least: int = 100
    most: int = 5000

    def __post_init__(self) -> None:
        for argument, value in (("epsilon", self.epsilon), ("cell", self.cell), ("sector", self.sector)):
            if not 0.0 < value < np.inf:
                raise InvalidArgumentError(argument, f"{value} is not a positive number")
        if not 0.0 < self.delta < 1.0:
            raise InvalidArgumentError("delta", f"{self.delta} is not a probability between 0 and 1")
        if not 1 <= self.least <= self.most:
            raise InvalidArgumentError("least", f"{self.least} is not between 1 and most = {self.most}")

    def particles_needed(self, bins: ArrayLike) -> Integers:
        """How many particles a belief over `bins` bins needs, (…), between `least` and `most`.

        (1) with the quantile of chi2 by Wilson and Hilferty, z being that of the normal law:

            n = (k - 1) / (2 epsilon) (1 - 2 / (9 (k - 1)) + sqrt(2 / (9 (k - 1))) z_{1 - delta})^3            (2)
        """
        freedom = np.asarray(bins, dtype=np.float64) - 1.0
        a = 2.0 / (9.0 * np.maximum(freedom, 1.0))
        z = float(ndtri(1.0 - self.delta))
        bound = freedom / (2.0 * self.epsilon) * (1.0 - a + np.sqrt(a) * z) ** 3
        return np.clip(np.ceil(bound), self.least, self.most).astype(np.int64)

    def bin_indices(self, poses: ArrayLike) -> Integers:
        """The bin of each pose (n, 3), as whole numbers (n, 3): column, row, sector of heading."""
        values = np.asarray(poses, dtype=np.float64)
        if values.ndim != 2 or values.shape[1] != 3 or not np.all(np.isfinite(values)):
            raise InvalidArgumentError("poses", f"of shape {values.shape} is not an array (n, 3) of finite numbers")
        headings = wrap_angle(values[:, 2])
        return np.floor(np.column_stack([values[:, :2] / self.cell, (headings + np.pi) / self.sector])).astype(np.int64)

    def count_needed_poses(self, poses: ArrayLike) -> int:
        """How many of the poses (n, 3), drawn independently in this order, are enough.

        The smallest m >= `least` such that m >= particles_needed(bins filled by the first m); n when there is none:
        what Fox's loop over single draws stops at, found for all of them at once. Raises InvalidArgumentError.
        """
        bins = self.bin_indices(poses)
        if len(bins) == 0:
            raise InvalidArgumentError("poses", "are none")
        _, firsts = np.unique(bins, axis=0, return_index=True)
        opens = np.zeros(len(bins), dtype=np.int64)
        opens[firsts] = 1
        drawn = np.arange(1, len(bins) + 1)
        done = drawn >= self.particles_needed(np.cumsum(opens))
        return int(drawn[np.argmax(done)]) if done.any() else len(bins)
