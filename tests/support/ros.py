"""The simulated ROS 2 of the module's kit, for tests: code that imports rclpy, and the world that it runs in."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graders.core.contract.local import initial_globals
from graders.core.contract.program import KitSettings

SETTINGS = KitSettings("ros")


@dataclass(frozen=True)
class Ros:
    """`names` are what a program finds."""

    names: dict[str, Any]

    def module(self, name: str) -> Any:
        return self.names["__builtins__"]["__import__"](name, None, None, ("",))

    def message(self, name: str) -> Any:
        """The class of a type of messages, "sensor_msgs/msg/LaserScan"."""
        return self.module("champs").TYPES[name]

    @property
    def world(self) -> Any:
        return self.module("rclpy.simulation").monde()

    def begun(self, seconds: float = 0.0) -> Ros:
        """A new world that lasts so long, with rclpy initialised."""
        simulation = self.module("rclpy.simulation")
        simulation.changer(simulation.Monde(round(seconds * simulation.SECONDE)))
        self.module("rclpy").try_shutdown()
        self.module("rclpy").init()
        return self

    def run(self, *codes: str) -> dict[str, Any]:
        """The names of a program in several pieces."""
        names = {"__name__": "essai", **self.names}
        for code in codes:
            exec(compile(code, "essai.py", "exec", dont_inherit=True), names)
        return names


def ros() -> Ros:
    return Ros(initial_globals(SETTINGS))
