"""Processor time of the service's parts, each with all that it has started; of the machine; of a fixed computation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from tests.benchmarks import processes
from tests.benchmarks.crowd.service import Service
from tests.benchmarks.measure import additions
from tests.support.live import children

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
    yield part, sum(processes.spent(pid))
    if part != "web":
        for child in children(pid):
            yield part, sum(processes.spent(child))
        return
    for child in processes.direct(pid):
        place = "graders" if processes.grades(child) else "figures"
        for one in (child, *children(child)):
            yield place, sum(processes.spent(one))


def machine() -> float:
    """Seconds that all processors together were not idle."""
    fields = list(map(int, Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:9]))
    return (sum(fields) - fields[3] - fields[4]) / processes.TICK


def calibration(rounds: int = 3) -> float:
    """Seconds of processor that the additions take now: the least of some."""
    return min(additions(ADDITIONS)[1] for _ in range(rounds))


def normalised(seconds: Mapping[str, float], unit: float) -> dict[str, float]:
    """As they would be where the additions take `REFERENCE`."""
    return {part: taken * REFERENCE / unit for part, taken in seconds.items()}
