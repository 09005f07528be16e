"""What passes between the trusted side and a template, as fixed records: an order or a report costs it no more than its
unpacking, since whatever a template touches after a fork is a page of memory to be copied."""

from __future__ import annotations

import struct
from typing import NamedTuple


class ChildLimits(NamedTuple):
    """The part of a policy that is known inside: what the kernel enforces, then what bounds answers and prints."""

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
    """How a child ended, as `os.wait4` tells it; `memory` is what the template holds of its own."""

    child_number: int
    status: int
    cpu_seconds: float
    max_rss_bytes: int
    template_memory: int


_NUMBER, _LIMITS, _REPORT = struct.Struct("<Q"), struct.Struct("<d9Q"), struct.Struct("<Qidqq")


def pack_fork(number: int, limits: ChildLimits) -> bytes:
    return _NUMBER.pack(number) + _LIMITS.pack(*limits)


def pack_kill(number: int) -> bytes:
    return _NUMBER.pack(number)


def unpack_order(order: bytes) -> tuple[int, bytes]:
    """The number of a child, and the packed limits of one that is to be forked: none of one that is to be killed."""
    return _NUMBER.unpack_from(order)[0], order[_NUMBER.size :]


def unpack_limits(packed: bytes) -> ChildLimits:
    return ChildLimits(*_LIMITS.unpack(packed))


def pack_report(report: ExitReport) -> bytes:
    return _REPORT.pack(*report)


def unpack_report(data: bytes) -> ExitReport:
    """Raises struct.error for what is no report."""
    return ExitReport(*_REPORT.unpack(data))
