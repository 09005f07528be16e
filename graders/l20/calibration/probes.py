"""What the three functions are asked by hand: steps ahead and back that slip, and constants that differ."""

from __future__ import annotations

import numpy as np

from graders.core.code.probes import Probes, read_array_or_reason
from graders.core.contract.values import Arguments
from graders.l20 import world
from graders.l20.calibration.cases import ROBOTS, drawn_journey, drawn_steps

STEADY = np.random.default_rng(29)
WAYS: tuple[Arguments, ...] = tuple((drawn_steps(STEADY, n),) for n in (1, 4, 6))
JOURNEYS: tuple[Arguments, ...] = tuple(drawn_journey(STEADY, 5 + k, robot) for k, robot in enumerate(ROBOTS))
CORRECTIONS: tuple[Arguments, ...] = tuple((drawn_steps(STEADY, 3), *robot) for robot in ROBOTS)


PROBES = (
    Probes(function="avance", calls=WAYS, kit=world.STILL, read=read_array_or_reason),
    Probes(function="etalonner", calls=JOURNEYS, kit=world.STILL, read=read_array_or_reason),
    Probes(function="corriger", calls=CORRECTIONS, kit=world.STILL, read=read_array_or_reason),
)
