"""What a node is shown: phases of a few identical scans each, and the plain scenario that the kit plays of them.

Before each phase the lidar sees nothing for a while. So a node may publish at once or from a timer, once or at each
scan, and read a parameter when it changes, at each scan or a few times a second: what is looked at is whether it has
stopped the robot during a phase where it must, and whether it is silent at the end of one where it must be.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from graders.core.contract.program import KitSettings
from graders.core.contract.values import Floats, Value

NODE = "ArretUrgence"
PARAMETER = "distance_min"
DEFAULT = 0.3
SCAN, COMMAND = "/scan", "/cmd_vel"
LASER_SCAN, TWIST = "sensor_msgs/msg/LaserScan", "geometry_msgs/msg/Twist"

#: Seconds between two scans.
PERIOD = 0.1
HALF = 10
"""Beams looked at on each side of the middle of the scan."""
MARGIN = 2


@dataclass(frozen=True)
class Pace:
    """Of a phase: scans that see nothing, then scans that are judged, of which so many let a node settle."""

    calm: int
    shown: int
    settling: int

    @property
    def length(self) -> float:
        """Seconds."""
        return (self.calm + self.shown) * PERIOD


JUDGED = Pace(4, 6, 3)
QUICK = Pace(0, 2, 1)


@dataclass(frozen=True, eq=False)
class Phase:
    """A scan: `ranges` in metres, none of which equals a bound; and what is asked of the node by then.

    `distance` is the value of the parameter, set from outside where it differs from that of the phase before; `told`
    says in French what there is to see.
    """

    ranges: Floats
    told: str
    stop: bool
    distance: float = DEFAULT
    angle_min: float = -math.pi
    range_min: float = 0.05
    range_max: float = 10.0

    @property
    def middle(self) -> int:
        return len(self.ranges) // 2


@dataclass(frozen=True, eq=False)
class Scene:
    """The life of one node; `launched` is the value of the parameter that it is launched with, None for its own."""

    phases: Sequence[Phase]
    launched: float | None = None
    pace: Pace = JUDGED

    def alone(self, number: int) -> Scene:
        """One of its phases by itself."""
        phase = self.phases[number]
        launched = self.launched if phase.distance == self.launched else None
        return Scene([phase], launched, self.pace)


def must_stop(ranges: Floats, distance: float, range_min: float, range_max: float) -> bool:
    """The rule itself, as the contract says it."""
    middle = len(ranges) // 2
    ahead = ranges[middle - HALF : middle + HALF].astype(np.float32)
    with np.errstate(invalid="ignore"):
        return bool(np.any((ahead > range_min) & (ahead < range_max) & (ahead < distance)))


def phase(ranges: Sequence[float] | Floats, told: str, **others: float) -> Phase:
    """A phase, and whether the node must stop in it."""
    made = Phase(np.array(ranges, dtype=float), told, False, **others)
    return replace(made, stop=must_stop(made.ranges, made.distance, made.range_min, made.range_max))


def scenario(scene: Scene) -> dict[str, Value]:
    """What the kit plays."""
    return {
        "duree": len(scene.phases) * scene.pace.length,
        "parametres": {} if scene.launched is None else {PARAMETER: scene.launched},
        "evenements": list(_events(scene)),
    }


def _events(scene: Scene) -> Iterator[Value]:
    known = DEFAULT if scene.launched is None else scene.launched
    for number, one in enumerate(scene.phases):
        start = number * scene.pace.length
        if one.distance != known:
            known = one.distance
            yield {"t": start, "parametre": PARAMETER, "valeur": known}
        nothing = np.full(len(one.ranges), math.inf)
        if scene.pace.calm:
            yield _scans(start, one, nothing, scene.pace.calm)
        yield _scans(start + scene.pace.calm * PERIOD, one, one.ranges, scene.pace.shown)


def _scans(start: float, one: Phase, ranges: Floats, times: int) -> Value:
    step = 2.0 * math.pi / len(ranges)
    message: dict[str, Value] = {
        "angle_min": one.angle_min,
        "angle_max": one.angle_min + step * (len(ranges) - 1),
        "angle_increment": step,
        "scan_time": PERIOD,
        "time_increment": PERIOD / len(ranges),
        "range_min": one.range_min,
        "range_max": one.range_max,
        "ranges": ranges,
    }
    event: dict[str, Value] = {"t": start, "topic": SCAN, "type": LASER_SCAN, "message": message}
    return event | {"fois": times, "periode": PERIOD}


def kit(rng: np.random.Generator) -> KitSettings:
    """The simulated ROS 2, which plays the class that is asked for."""
    return KitSettings("ros", {"noeuds": [NODE], "seed": int(rng.integers(2**31))})


STILL = KitSettings("ros", {"noeuds": [NODE], "seed": 0})
