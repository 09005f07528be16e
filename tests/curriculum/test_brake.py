"""The node that brakes, as the séance on ROS 2 writes it: it stops when in doubt. Run against a stand-in for rclpy."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

import server

LESSON = Path(server.__file__).parents[1] / "curriculum" / "l20" / "seances" / "ros2.md"
CODE = re.findall(r"```python\n(.*?)```", LESSON.read_text(encoding="utf-8"), re.DOTALL)


@dataclass
class Twist:
    forward: float = 0.0


@dataclass
class LaserScan:
    ranges: list[float]
    angle_min: float = -math.pi
    range_min: float = 0.1
    range_max: float = 10.0
    angle_increment: float = field(init=False)

    def __post_init__(self) -> None:
        self.angle_increment = math.tau / len(self.ranges)


class Node:
    """A node that is alone: what it declares, hears and says."""

    def __init__(self, name: str) -> None:
        self.parameters: dict[str, Any] = {}
        self.heard: dict[str, Callable[[Any], None]] = {}
        self.said: list[Twist] = []

    def declare_parameter(self, name: str, value: object) -> None:
        self.parameters[name] = value

    def get_parameter(self, name: str) -> SimpleNamespace:
        return SimpleNamespace(value=self.parameters[name])

    def create_subscription(self, kind: type, topic: str, call: Callable[[Any], None], qos: object) -> None:
        self.heard[topic] = call

    def create_publisher(self, kind: type, topic: str, qos: object) -> SimpleNamespace:
        return SimpleNamespace(publish=self.said.append)


STANDS_IN = {
    "rclpy": {},
    "rclpy.executors": {"ExternalShutdownException": Exception},
    "rclpy.node": {"Node": Node},
    "rclpy.qos": {"qos_profile_sensor_data": None},
    "sensor_msgs": {},
    "sensor_msgs.msg": {"LaserScan": LaserScan},
    "std_msgs": {},
    "std_msgs.msg": {"Float32": SimpleNamespace},
    "geometry_msgs": {},
    "geometry_msgs.msg": {"Twist": Twist},
}


@pytest.fixture
def brake(monkeypatch: pytest.MonkeyPatch) -> Node:
    for name, content in STANDS_IN.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    names: dict[str, Any] = {"__name__": "frein"}
    for code in CODE:
        if "class Vigie" in code or "class Frein" in code:
            exec(compile(code, "ros2.md", "exec"), names)
    return names["Frein"]()


def moves(brake: Node, scan: LaserScan | None) -> bool:
    """Does it let a speed through, once it has seen this scan?"""
    if scan is not None:
        brake.heard["/scan"](scan)
    brake.heard["/cmd_vel_voulue"](Twist(0.5))
    return brake.said[-1].forward == 0.5


def front(value: float, elsewhere: float = 5.0) -> LaserScan:
    """36 rays, the first one behind: `value` in all that look ahead."""
    return LaserScan([value if 15 <= k <= 21 else elsewhere for k in range(36)])


@pytest.mark.parametrize("value", [1.0, 5.0, math.inf, 12.0])
def test_a_way_that_is_seen_to_be_free_is_free(brake: Node, value: float) -> None:
    assert moves(brake, front(value))


@pytest.mark.parametrize("value", [0.25, 0.1, 0.05, 0.0, -math.inf, math.nan])
def test_what_is_near_or_too_near_or_unseen_stops(brake: Node, value: float) -> None:
    assert not moves(brake, front(value))


def test_one_ray_too_near_is_enough_and_one_that_failed_is_not(brake: Node) -> None:
    for value, free in ((-math.inf, False), (math.nan, True)):
        scan = front(3.0)
        scan.ranges[18] = value
        assert moves(brake, scan) is free


def test_a_lidar_that_does_not_look_ahead_lets_nothing_through(brake: Node) -> None:
    scan = front(3.0)
    scan.angle_min, scan.angle_increment = 1.0, 0.01
    assert not moves(brake, scan)


def test_what_stands_beside_or_behind_does_not_stop(brake: Node) -> None:
    assert moves(brake, front(3.0, elsewhere=0.2))


def test_it_stops_before_the_first_scan_and_at_once_when_something_comes(brake: Node) -> None:
    assert not moves(brake, None)
    assert moves(brake, front(2.0))
    brake.heard["/scan"](front(0.2))
    assert brake.said[-1].forward == 0.0


def test_a_lidar_that_counts_from_zero_looks_ahead_at_both_ends(brake: Node) -> None:
    scan = LaserScan([3.0] * 36, angle_min=0.0)
    assert moves(brake, scan)
    scan.ranges[-1] = 0.2
    assert not moves(brake, scan)
