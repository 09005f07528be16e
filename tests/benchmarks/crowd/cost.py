"""Processor time of the service's parts, each with all that it has started; of the machine; of a fixed computation."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from tests.benchmarks.crowd.service import Service
from tests.benchmarks.measure import additions
from tests.support.live import children

TICK = os.sysconf("SC_CLK_TCK")
UTIME, CUTIME = 11, 13  # places in /proc/pid/stat, after the name
GRADING = "server.grading"  # in the command of a worker that a web process has started
ADDITIONS = 5_000_000
REFERENCE = 0.25  # seconds that they take on the processor to which figures are brought


def spent(service: Service) -> dict[str, float]:
    """Seconds since each part began."""
    found: dict[str, float] = {}
    for part, pids in service.parts.items():
        for pid in pids:
            for place, seconds in _below(part, pid):
                found[place] = found.get(place, 0.0) + seconds
    return found


def _below(part: str, pid: int) -> Iterator[tuple[str, float]]:
    """A web process has workers and a process that draws: they are told apart by their commands."""
    yield part, _own(pid)
    if part != "web":
        for child in children(pid):
            yield part, _own(child)
        return
    for child in _direct(pid):
        place = "graders" if GRADING in _command(child) else "figures"
        for one in (child, *children(child)):
            yield place, _own(one)


def _direct(pid: int) -> list[int]:
    return [int(one) for task in Path(f"/proc/{pid}/task").glob("*/children") for one in task.read_text().split()]


def _command(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/cmdline").read_text()
    except OSError:
        return ""


def _own(pid: int) -> float:
    """With those of its children that have ended; nothing of one that has ended itself, which its parent has then."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, fields[UTIME : CUTIME + 2])) / TICK


def machine() -> float:
    """Seconds that all processors together were not idle."""
    fields = list(map(int, Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]))
    return (sum(fields) - fields[3] - fields[4]) / TICK


def calibration(rounds: int = 3) -> float:
    """Seconds of processor that the additions take now: the least of some."""
    return min(additions(ADDITIONS)[1] for _ in range(rounds))


def normalised(seconds: Mapping[str, float], unit: float) -> dict[str, float]:
    """As they would be where the additions take `REFERENCE`."""
    return {part: taken * REFERENCE / unit for part, taken in seconds.items()}
