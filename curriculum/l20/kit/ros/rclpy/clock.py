"""L'horloge d'un nœud : celle du monde simulé."""

from rclpy import simulation
from rclpy.clock_type import ClockType
from rclpy.time import Time

__all__ = ["Clock", "ClockType", "ROSClock"]


class Clock:
    def __init__(self, *, clock_type=ClockType.SYSTEM_TIME):
        self._clock_type = clock_type

    @property
    def clock_type(self):
        return self._clock_type

    def now(self):
        return Time(nanoseconds=simulation.monde().maintenant, clock_type=self._clock_type)


class ROSClock(Clock):
    def __init__(self):
        super().__init__(clock_type=ClockType.ROS_TIME)
