"""How long commands take to start, each figure normalised too.

    PYTHONPATH=. python tests/benchmarks/bench_start.py [rounds]

`balise --help` and `balise grade` to their end, `balise serve` to its address, on data of an earlier start; then the
first lesson that somebody reads there. Seconds of the wall, and of processor time: those of the command and of the
processes that it has waited for. Normalised: divided by a loop of ten million additions timed in the same seconds, and
multiplied by half a second. Modules compiled to bytecode beforehand, as an installation leaves them.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
import urllib.request
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.measure import ADDITIONS, REFERENCE, Goal, Row, additions, figure, median, table

ROOT = Path(__file__).parents[2]
ADDRESS = re.compile(r"Balise est prête : (\S+)/")
EXERCISE, LESSON = "l20/poses", "/l20/lire/localiser"
GOALS = {"--help": Goal(0.15), "grade": Goal(0.6), "serve": Goal(2.0), "first lesson": None, "second lesson": None}

Timed = tuple[float, float]  # seconds of the wall, of processor time


def run(*words: str) -> Timed:
    before, wall = os.times(), time.perf_counter()
    subprocess.run([sys.executable, "-m", "server", *words], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
    wall, after = time.perf_counter() - wall, os.times()
    return wall, after.children_user - before.children_user + after.children_system - before.children_system


def serve(data: str) -> dict[str, Timed]:
    wall = time.perf_counter()
    command = [sys.executable, "-m", "server", "serve", "--port", "0", "--data", data]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as service:
        try:
            assert service.stdout is not None
            address = next(found[1] for line in service.stdout if (found := ADDRESS.search(line)))
            found = {"serve": (time.perf_counter() - wall, _spent(service.pid))}
            for name in ("first lesson", "second lesson"):
                wall, processor = time.perf_counter(), _spent(service.pid)
                urllib.request.urlopen(address + LESSON).read()
                found[name] = time.perf_counter() - wall, _spent(service.pid) - processor
        finally:
            service.terminate()
    return found


def _spent(pid: int) -> float:
    """Processor time of a process that runs, without those that it has started."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Found:
    """Seconds that one command takes, of the wall and of processor, and the same normalised: medians."""

    wall: float
    processor: float
    normal_wall: float
    normal_processor: float


def measured(rounds: int) -> dict[str, Found]:
    solution = ROOT / "graders" / EXERCISE / "solution.py"
    taken: dict[str, list[tuple[Timed, Timed]]] = {name: [] for name in GOALS}
    with tempfile.TemporaryDirectory() as folder:
        serve(folder)  # migrates, and remembers the course
        run("grade", EXERCISE, str(solution))
        for _ in range(rounds):
            unit = additions(ADDITIONS)
            found = {"--help": run("--help"), "grade": run("grade", EXERCISE, str(solution)), **serve(folder)}
            for name, timed in found.items():
                taken[name].append((timed, unit))
    return {name: _found(every) for name, every in taken.items()}


def _found(every: list[tuple[Timed, Timed]]) -> Found:
    plain = (median([timed[clock] for timed, _ in every]) for clock in (0, 1))
    normal = (median([REFERENCE * timed[clock] / unit[clock] for timed, unit in every]) for clock in (0, 1))
    return Found(*plain, *normal)


def rows(rounds: int) -> list[Row]:
    return [
        Row(f"start: {name}", "s", one.wall, one.normal_wall, one.normal_processor, goal=GOALS[name])
        for name, one in measured(rounds).items()
    ]


def main(rounds: int) -> None:
    rows = [
        [name, *map(figure, (one.wall, one.processor, one.normal_wall, one.normal_processor)), str(GOALS[name] or "")]
        for name, one in measured(rounds).items()
    ]
    head = ["seconds", "wall", "processor", "wall, normalised", "processor, normalised", "goal (wall, normalised)"]
    print(table(head, rows))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
