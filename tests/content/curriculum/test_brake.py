"""The node that brakes, as the séance on ROS 2 writes it: it stops when in doubt. Run in the kit's own ROS 2."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import server
from tests.support.ros import Ros, ros

LESSON = Path(server.__file__).parents[1] / "curriculum" / "l20" / "seances" / "ros2.md"
CODE = re.findall(r"```python\n(.*?)```", LESSON.read_text(encoding="utf-8"), re.DOTALL)


class Brake:
    """The node, what it hears by topic, what it has said to the motors."""

    def __init__(self, simulated: Ros) -> None:
        names = simulated.run(*(code for code in CODE if "class Vigie" in code or "class Frein" in code))
        self.node = names["Frein"]()
        self.heard: dict[str, Callable[[Any], None]] = {s.topic_name: s.callback for s in self.node.subscriptions}
        self.said: list[Any] = []
        simulated.world.ecoutes.append(lambda at, topic, message: topic == "/cmd_vel" and self.said.append(message))


SIMULATED = ros()
LaserScan, Twist = SIMULATED.message("sensor_msgs/msg/LaserScan"), SIMULATED.message("geometry_msgs/msg/Twist")


@pytest.fixture
def brake() -> Brake:
    return Brake(SIMULATED.begun())


def scan_of(ranges: list[float], angle_min: float = -math.pi) -> Any:
    step = math.tau / len(ranges)
    return LaserScan(ranges=ranges, angle_min=angle_min, angle_increment=step, range_min=0.1, range_max=10.0)


def moves(brake: Brake, scan: Any) -> bool:
    """Does it let a speed through, once it has seen this scan?"""
    if scan is not None:
        brake.heard["/scan"](scan)
    wanted = Twist()
    wanted.linear.x = 0.5
    brake.heard["/cmd_vel_voulue"](wanted)
    return bool(brake.said[-1].linear.x == 0.5)


def front(value: float, elsewhere: float = 5.0) -> Any:
    """36 rays, the first one behind: `value` in all that look ahead."""
    return scan_of([value if 15 <= k <= 21 else elsewhere for k in range(36)])


@pytest.mark.parametrize("value", [1.0, 5.0, math.inf, 12.0])
def test_a_way_that_is_seen_to_be_free_is_free(brake: Brake, value: float) -> None:
    assert moves(brake, front(value))


@pytest.mark.parametrize("value", [0.25, 0.1, 0.05, 0.0, -math.inf, math.nan])
def test_what_is_near_or_too_near_or_unseen_stops(brake: Brake, value: float) -> None:
    assert not moves(brake, front(value))


def test_one_ray_too_near_is_enough_and_one_that_failed_is_not(brake: Brake) -> None:
    for value, free in ((-math.inf, False), (math.nan, True)):
        scan = front(3.0)
        scan.ranges[18] = value
        assert moves(brake, scan) is free


def test_a_lidar_that_does_not_look_ahead_lets_nothing_through(brake: Brake) -> None:
    scan = front(3.0)
    scan.angle_min, scan.angle_increment = 1.0, 0.01
    assert not moves(brake, scan)


def test_what_stands_beside_or_behind_does_not_stop(brake: Brake) -> None:
    assert moves(brake, front(3.0, elsewhere=0.2))


def test_it_stops_before_the_first_scan_and_at_once_when_something_comes(brake: Brake) -> None:
    assert not moves(brake, None)
    assert moves(brake, front(2.0))
    brake.heard["/scan"](front(0.2))
    assert brake.said[-1] == Twist()


def test_a_lidar_that_counts_from_zero_looks_ahead_at_both_ends(brake: Brake) -> None:
    scan = scan_of([3.0] * 36, angle_min=0.0)
    assert moves(brake, scan)
    scan.ranges[-1] = 0.2
    assert not moves(brake, scan)
