"""The time at which a process that was stopped runs out of it, written behind its output (`server.sandbox.output`)."""

from __future__ import annotations

import os
import struct
from time import monotonic

from . import inner

_ALARM = struct.Struct("<d")


def seconds_left_after_stop() -> float:
    """Return the seconds that a process that was stopped has left; 0 where it was not, or has none."""
    return max(_alarm_time() - monotonic(), 0.0)


def was_stopped() -> bool:
    """Whether this process was stopped for a while."""
    return _alarm_time() > 0


def _alarm_time() -> float:
    try:
        size = os.fstat(inner.TRACEBACK).st_size
        at: float = _ALARM.unpack(os.pread(inner.TRACEBACK, _ALARM.size, size - _ALARM.size))[0]
    except OSError:  # the program has closed it
        return 0.0
    return at
