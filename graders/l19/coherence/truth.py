"""What is right in l19/coherence, from `reference`."""

from __future__ import annotations

import numpy as np

from graders.core.contract.values import Floats
from reference.filters.gaussian import Innovation
from reference.filters.scalar import mean_nees_band

LEVEL = 0.95


def right_nees(true: Floats, estimated: Floats, P: Floats) -> float:
    """An estimation error is normalised as an innovation is."""
    return Innovation(true - estimated, P).nis


def right_band(n: int, N: int, level: float = LEVEL) -> tuple[float, float]:
    return mean_nees_band(N, n, level)


def right_verdict(true: Floats, estimated: Floats, covariances: Floats) -> tuple[float, int]:
    """The mean NEES of the runs, and 1 for a filter too sure of itself, -1 for one too careful, else 0."""
    values = [right_nees(*run) for run in zip(true, estimated, covariances, strict=True)]
    mean = float(np.mean(values))
    low, high = right_band(true.shape[1], len(true))
    return mean, int(mean > high) - int(mean < low)
