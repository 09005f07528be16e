"""The timer of a program's time of the wall."""

from __future__ import annotations

import signal

from . import alarm
from .course_channel import CourseCaller

#: Minimum of a timer: zero seconds would disable it.
MIN_TIMER_SECONDS = 0.001


class WallClock:
    """Times a program. Waiting for the course is not its own time, up to as much as it has itself.

    The trusted side, which sees no call, gives a program twice its time once it calls the course. What is left of its
    own is known here alone; after a stop for a while, there alone.
    """

    def __init__(self, course: CourseCaller) -> None:
        self._course = course
        self._seconds_left = self._course_seconds_left = 0.0

    def set_course_seconds(self, seconds: float) -> None:
        """Set the time for the functions of the course."""
        self._course_seconds_left = seconds

    def start(self, seconds: float | None) -> None:
        """Start the timer with so many seconds; None: with those that were left when it was stopped last."""
        if seconds is None or (self._counts_own_time() and self._seconds_left < seconds):
            seconds = self._seconds_left
        signal.setitimer(signal.ITIMER_REAL, max(seconds, MIN_TIMER_SECONDS))

    def add_seconds(self, seconds: float) -> None:
        """Give the program so many seconds more."""
        signal.setitimer(signal.ITIMER_REAL, seconds + signal.getitimer(signal.ITIMER_REAL)[0])

    def stop(self) -> None:
        left, _ = signal.setitimer(signal.ITIMER_REAL, 0)
        self._seconds_left = left + self._waited_for_course()

    def restart_if_time_left(self) -> bool:
        """When the timer says that no time is left: whether there is some, for which it is started anew."""
        left = alarm.seconds_left_after_stop() or self._waited_for_course()
        if left > MIN_TIMER_SECONDS:
            signal.setitimer(signal.ITIMER_REAL, left)
        return left > MIN_TIMER_SECONDS

    def _counts_own_time(self) -> bool:
        return self._course.has_called and not alarm.was_stopped()

    def _waited_for_course(self) -> float:
        """Return the seconds for which the program has waited for the course since the last time."""
        if not self._counts_own_time():
            return 0.0
        waited = min(self._course.take_waited_seconds(), self._course_seconds_left)
        self._course_seconds_left -= waited
        return waited
