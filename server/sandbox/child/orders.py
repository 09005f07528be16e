"""Messages between the trusted side and a template, as fixed records: they cost a template next to nothing, since each
page that it touches after a fork must be copied."""

from __future__ import annotations

import signal
import struct
from typing import NamedTuple


class ChildLimits(NamedTuple):
    """The part of a policy that children know: limits that the kernel enforces, then bounds of answers and output."""

    cpu_seconds: float
    memory_bytes: int
    files: int
    file_bytes: int
    folder_bytes: int
    threads: int
    stdout_bytes: int
    frame_bytes: int
    depth: int
    items: int


class ExitReport(NamedTuple):
    """Exit of a child as `os.wait4` reports it; `template_memory` is the template's private memory in bytes."""

    child_number: int
    status: int
    cpu_seconds: float
    max_rss_bytes: int
    template_memory: int


_NUMBER, _LIMITS, _REPORT = struct.Struct("<Q"), struct.Struct("<d9Q"), struct.Struct("<Qidqq")


_KILL, _STOP, _GO_ON = b"k", b"s", b"g"
#: Signals to a child, by their orders.
SIGNALS = {_KILL: signal.SIGKILL, _STOP: signal.SIGSTOP, _GO_ON: signal.SIGCONT}


def pack_fork_order(number: int, limits: ChildLimits) -> bytes:
    return _NUMBER.pack(number) + _LIMITS.pack(*limits)


def pack_kill_order(number: int) -> bytes:
    return _NUMBER.pack(number) + _KILL


def pack_stop_order(number: int) -> bytes:
    return _NUMBER.pack(number) + _STOP


def pack_continue_order(number: int) -> bytes:
    return _NUMBER.pack(number) + _GO_ON


def unpack_order(order: bytes) -> tuple[int, bytes]:
    """Return the number of a child and its packed limits, or a key of SIGNALS."""
    return _NUMBER.unpack_from(order)[0], order[_NUMBER.size :]


def unpack_limits(packed: bytes) -> ChildLimits:
    return ChildLimits(*_LIMITS.unpack(packed))


def pack_report(report: ExitReport) -> bytes:
    return _REPORT.pack(*report)


def unpack_report(data: bytes) -> ExitReport:
    """Unpack a report. Raises struct.error for other bytes."""
    return ExitReport(*_REPORT.unpack(data))
