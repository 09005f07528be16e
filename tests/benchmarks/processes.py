"""Processes of this machine, as the kernel tells of them: whose children they are, what they have spent."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

TICK = os.sysconf("SC_CLK_TCK")
UTIME, CUTIME = 11, 13  # places in /proc/pid/stat, after the name
GRADING = "server.grading"  # in the command of a worker that a web process has started


def direct(pid: int) -> list[int]:
    """The children of a process; none of a thread that ends meanwhile."""
    found = list[int]()
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):
            found += map(int, task.read_text().split())
    return found


def grades(pid: int) -> bool:
    """Whether it is a worker of submissions; False for one that has ended."""
    try:
        return GRADING in Path(f"/proc/{pid}/cmdline").read_text()
    except OSError:
        return False


def spent(pid: int) -> tuple[float, float]:
    """Seconds of processor, its own and those of its children that have ended; nothing of one that has ended itself,
    which its parent has then."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0, 0.0
    mine, ended = (sum(map(int, fields[place : place + 2])) / TICK for place in (UTIME, CUTIME))
    return mine, ended
