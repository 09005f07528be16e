"""The time at which a process that was stopped runs out of it, written behind its output (`server.sandbox.output`)."""

from __future__ import annotations

import os
import struct
from time import monotonic

from . import inner

_ALARM = struct.Struct("<d")


def seconds_left_after_stop() -> float:
    """Return the seconds that a process that was stopped has left; 0 where it was not, or has none."""
    try:
        size = os.fstat(inner.TRACEBACK).st_size
        at: float = _ALARM.unpack(os.pread(inner.TRACEBACK, _ALARM.size, size - _ALARM.size))[0]
    except OSError:  # the program has closed it
        return 0.0
    return at - monotonic() if at else 0.0
