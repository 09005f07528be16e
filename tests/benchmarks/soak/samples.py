"""Memory, open files and disk of a running service, sampled; and whether they grew."""

from __future__ import annotations

import sqlite3
import statistics
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks import processes
from tests.benchmarks.crowd.service import Service
from tests.support.live import children

MEGABYTE = 1e6
#: By how much the median of the last quarter may exceed that of the second: a share, and an amount.
GROWTH = 0.10
SLACK = {"web_mb": 30.0, "graders_mb": 30.0, "figures_mb": 30.0, "open_files": 20.0}
#: Each regrade grades all attempts again: what is stored is counted by gradings, first or anew.
GRADINGS = "SELECT (SELECT count(*) FROM grading) + (SELECT count(*) FROM regrade_item)"
#: The data of a grading (code, verdict, figures, replay) may vary by this factor from one half to the other.
DATA_GROWTH = 1.25
FEWEST = 16  # samples, below which nothing is said of growth


@dataclass(frozen=True)
class Sample:
    """One moment. Memory is the proportional set size, in megabytes; `seconds` since sampling began."""

    seconds: float
    web_mb: float
    graders_mb: float
    figures_mb: float
    open_files: int
    data_mb: float
    gradings: int


def take_sample(service: Service, data: Path, seconds: float) -> Sample:
    """Sample a service on SQLite with one web process."""
    (web,) = service.parts["web"]
    graders, figures = list[int](), list[int]()
    for child in processes.direct(web):
        (graders if processes.grades(child) else figures).extend([child, *children(child)])
    with closing(sqlite3.connect(f"file:{data / 'balise.sqlite3'}?mode=ro", uri=True, timeout=60.0)) as connection:
        (gradings,) = connection.execute(GRADINGS).fetchone()
    return Sample(
        seconds,
        _memory([web]),
        _memory(graders),
        _memory(figures),
        sum(_open_files(pid) for pid in (web, *graders, *figures)),
        sum(_size(path) for path in data.rglob("*")) / MEGABYTE,
        gradings,
    )


def _memory(pids: Sequence[int]) -> float:
    return sum(_proportional_set_size(pid) for pid in pids) / MEGABYTE


def _proportional_set_size(pid: int) -> float:
    """Return bytes; 0 for a process that has ended."""
    try:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    return 1024.0 * sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))


def _open_files(pid: int) -> int:
    try:
        return sum(1 for _ in Path(f"/proc/{pid}/fd").iterdir())
    except OSError:
        return 0


def _size(path: Path) -> int:
    try:
        return path.stat().st_size if path.is_file() else 0
    except OSError:
        return 0


def find_growth(samples: Sequence[Sample]) -> list[str]:
    """Return a sentence for each measure that grew from the second quarter to the last, when the service was warm."""
    if len(samples) < FEWEST:
        return [f"{len(samples)} samples are too few to judge growth: at least {FEWEST}"]
    return list(_find_growth(samples))


def _find_growth(samples: Sequence[Sample]) -> Iterator[str]:
    quarter = len(samples) // 4
    second, last = samples[quarter : 2 * quarter], samples[-quarter:]
    for name, slack in SLACK.items():
        before, after = (_median(part, name) for part in (second, last))
        if after > before * (1 + GROWTH) + slack:
            yield f"{name} grew from {before:.0f} to {after:.0f}"
    middle = samples[len(samples) // 2]
    earlier, later = _bytes_per_grading(samples[quarter], middle), _bytes_per_grading(middle, samples[-1])
    if later > DATA_GROWTH * earlier:
        yield f"a grading's data grew from {earlier:.0f} to {later:.0f} bytes"


def _median(samples: Sequence[Sample], name: str) -> float:
    value: Callable[[Sample], float] = lambda sample: getattr(sample, name)  # noqa: E731
    return statistics.median(map(value, samples))


def _bytes_per_grading(first: Sample, last: Sample) -> float:
    return MEGABYTE * (last.data_mb - first.data_mb) / max(1, last.gradings - first.gradings)
