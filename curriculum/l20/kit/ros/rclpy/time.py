"""Des instants, en nanosecondes entières."""

import builtin_interfaces.msg

from rclpy.clock_type import ClockType
from rclpy.duration import Duration


class Time:
    def __init__(self, *, seconds=0, nanoseconds=0, clock_type=ClockType.SYSTEM_TIME):
        if seconds < 0 or nanoseconds < 0:
            raise ValueError("Seconds and nanoseconds value must not be negative")
        self._nanoseconds = int(seconds * 10**9) + int(nanoseconds)
        self._clock_type = clock_type

    @property
    def nanoseconds(self):
        return self._nanoseconds

    @property
    def clock_type(self):
        return self._clock_type

    def seconds_nanoseconds(self):
        return divmod(self._nanoseconds, 10**9)

    def to_msg(self):
        secondes, reste = self.seconds_nanoseconds()
        return builtin_interfaces.msg.Time(sec=secondes, nanosec=reste)

    @classmethod
    def from_msg(cls, msg, clock_type=ClockType.ROS_TIME):
        return cls(seconds=msg.sec, nanoseconds=msg.nanosec, clock_type=clock_type)

    def __repr__(self):
        return f"Time(nanoseconds={self._nanoseconds}, clock_type={self._clock_type.name})"

    def __add__(self, other):
        if not isinstance(other, Duration):
            return NotImplemented
        return Time(nanoseconds=self._nanoseconds + other.nanoseconds, clock_type=self._clock_type)

    __radd__ = __add__

    def __sub__(self, other):
        if isinstance(other, Time):
            self._meme_horloge(other)
            return Duration(nanoseconds=self._nanoseconds - other._nanoseconds)
        if isinstance(other, Duration):
            return Time(nanoseconds=self._nanoseconds - other.nanoseconds, clock_type=self._clock_type)
        return NotImplemented

    def _meme_horloge(self, autre):
        if self._clock_type != autre._clock_type:
            raise TypeError("Can't compare times with different clock types")

    def _comparer(self, autre, comparaison):
        if not isinstance(autre, Time):
            return NotImplemented
        self._meme_horloge(autre)
        return comparaison(self._nanoseconds, autre._nanoseconds)

    def __eq__(self, other):
        return self._comparer(other, lambda a, b: a == b)

    def __lt__(self, other):
        return self._comparer(other, lambda a, b: a < b)

    def __le__(self, other):
        return self._comparer(other, lambda a, b: a <= b)

    def __gt__(self, other):
        return self._comparer(other, lambda a, b: a > b)

    def __ge__(self, other):
        return self._comparer(other, lambda a, b: a >= b)

    def __hash__(self):
        return hash(self._nanoseconds)
