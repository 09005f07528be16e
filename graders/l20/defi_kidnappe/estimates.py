"""The trial of weights that are unequal: whoever counts the particles of a place, and not what they weigh, is refused.

A filter that returns equal weights has no use for them in its own runs; `estimer` is given others here.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from graders.core.code.bench import Bench
from graders.core.contract.values import Arguments
from graders.l20 import journeys
from graders.l20.mcl.answers import ESTIMATE
from graders.l20.mcl.estimates import HEAVY, heavy_beside_light, require_estimate_near_weight
from graders.l20.mcl.scenes import ALWAYS, SPREAD
from graders.l20.mcl.telling import observed

#: Where light particles are: a cell away from the heavy ones, and in another room.
A_CELL_AWAY, FAR_AWAY = np.array([5.3, 3.1, 0.3]), np.array([19.4, 11.3, -2.0])


@cache
def unequal() -> Arguments:
    """Make forty particles that weigh nine tenths, and 120 light ones a cell away."""
    return heavy_beside_light(A_CELL_AWAY, 120)


@cache
def outnumbered() -> Arguments:
    """Make ten particles with nearly all the weight, and fifty in another room that have nearly none."""
    rng = np.random.default_rng(ALWAYS + 1)
    cloud = np.vstack([HEAVY, journeys.around(HEAVY, 9, SPREAD, rng), journeys.around(FAR_AWAY, 50, SPREAD, rng)])
    weights = np.concatenate([[0.15], np.full(9, 0.85 / 9), np.full(50, 1e-6)])
    return np.roll(cloud, 30, axis=0), np.roll(weights / weights.sum(), 30)


@observed(ESTIMATE)
def weighed(bench: Bench) -> None:
    """The weight is on few particles, near many light ones, then far from them."""
    for cloud in (unequal(), outnumbered()):
        require_estimate_near_weight(bench, cloud)
