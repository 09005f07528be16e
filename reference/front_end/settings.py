"""What a front end is told: how far, how near, how sure. The defaults map real logs."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from reference.errors import InvalidArgumentError
from reference.registration import MatchingSettings
from reference.se2 import Floats, Pose

CHI2_99 = 11.34


class FrontEndError(InvalidArgumentError):
    """A journey from which no map can be made; `argument` names what is at fault."""


@dataclass(frozen=True)
class StepNoise:
    """Standard deviations of a step of odometry, as sums of a constant, a share of the distance and one of the turn.

    Of each coordinate in metres: `metres` + `per_metre` d + `per_radian` |t|; of the heading in radians: `radians` +
    `turn_per_metre` d + `turn_per_radian` |t|, for a step of d metres that turns by t.
    """

    metres: float = 0.02
    per_metre: float = 0.08
    per_radian: float = 0.05
    radians: float = 0.02
    turn_per_metre: float = 0.03
    turn_per_radian: float = 0.08

    def __post_init__(self) -> None:
        for part in fields(self):
            value, constant = getattr(self, part.name), part.name in ("metres", "radians")
            if not 0.0 <= value < np.inf or (constant and value == 0.0):
                raise FrontEndError(part.name, f"{value} is not a standard deviation")

    def covariance(self, step: Pose) -> Floats:
        """The covariance (3, 3) of a step (3,)."""
        d, t = float(np.hypot(step[0], step[1])), abs(float(step[2]))
        along = self.metres + self.per_metre * d + self.per_radian * t
        turned = self.radians + self.turn_per_metre * d + self.turn_per_radian * t
        return np.diag([along**2, along**2, turned**2])


@dataclass(frozen=True)
class FrontEndSettings:
    """Key poses every `key_distance` m or `key_turn` rad, or where less than `key_overlap` of a scan was seen before.

    Each scan is matched with the `recent` key scans before it.

    The search looks `reach` m and `turn` rad either way, or three standard deviations of the step where that is more.
    Loops: from a key pose to others `min_gap` before it or more, `tries` of them at most, the nearest first; what is
    matched is the last `behind` key scans with those up to `around` before and after the old pose. A match counts if at
    least `link_overlap` (`loop_overlap`) of its points lie near, and if odometry contradicts it by a squared error of
    `gate` at most; loops of the newest `voters` key poses that exceed it are believed together where that costs less
    than to refuse them all. The search of a loop goes as far as the pose may have drifted, `drift` m a key pose since
    the last closure, and `farthest` m at most.
    """

    key_distance: float = 0.4
    key_turn: float = 0.4
    key_overlap: float = 0.75
    recent: int = 12
    reach: float = 0.3
    turn: float = 0.25
    min_gap: int = 20
    tries: int = 2
    behind: int = 4
    around: int = 6
    link_overlap: float = 0.5
    loop_overlap: float = 0.7
    gate: float = CHI2_99
    drift: float = 0.02
    farthest: float = 8.0
    voters: int = 30
    noise: StepNoise = field(default_factory=StepNoise)
    matching: MatchingSettings = field(default_factory=MatchingSettings)

    def __post_init__(self) -> None:
        for name in ("key_distance", "key_turn", "reach", "turn", "gate", "drift", "farthest"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise FrontEndError(name, f"{getattr(self, name)} is not a positive number")
        for name, least in (("recent", 1), ("voters", 1), ("min_gap", 2), ("tries", 1), ("behind", 1), ("around", 0)):
            if not getattr(self, name) >= least:
                raise FrontEndError(name, f"{getattr(self, name)} is less than {least}")
        for name in ("key_overlap", "link_overlap", "loop_overlap"):
            if not 0.0 < getattr(self, name) <= 1.0:
                raise FrontEndError(name, f"{getattr(self, name)} is not a share")
