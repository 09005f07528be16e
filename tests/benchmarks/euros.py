"""What a million verdicts cost in processor time, beside what it costs others to start what they judge in. By hand:

    PYTHONPATH=. python tests/benchmarks/euros.py

A verdict's processor time is measured here, that of the trusted side and of the child, of right answers and wrong ones;
a cold interpreter that loads NumPy is too, as others start one for each run of a program. The start of a container is
published by others, and so is what a processor costs: `region.toml` tells both, with their sources.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.bench_exchange import measured
from tests.benchmarks.measure import Pace, Row, figure, median, table

KNOWN = Path(__file__).with_name("region.toml")
EXERCISES = ("l20/poses", "l20/slam_graphe")
MILLION, HOUR = 1_000_000, 3600.0
COLD = [sys.executable, "-I", "-c", "import numpy"]
COLD_ROUNDS = 5


@dataclass(frozen=True)
class Price:
    """Euros of a processor for an hour; seconds that the start of a container takes, by where its image stands."""

    processor: float
    containers: dict[str, float]

    @staticmethod
    def read(path: Path = KNOWN) -> Price:
        known = tomllib.loads(path.read_text(encoding="utf-8"))
        return Price(known["euros"]["processor"], known["containers"])

    def million(self, seconds: float) -> float:
        """Euros of a million times so many seconds of a processor."""
        return MILLION * seconds / HOUR * self.processor


def cold_interpreter() -> float:
    """Seconds of processor, normalised, of an interpreter that starts and loads NumPy."""
    pace, taken = Pace(), []
    for _ in range(COLD_ROUNDS):
        pace.sample()
        before = os.times()
        subprocess.run(COLD, check=True)
        after = os.times()
        taken.append(after.children_user - before.children_user + after.children_system - before.children_system)
    return median(taken) * pace.processor


def verdicts(rounds: int) -> dict[str, float]:
    """Seconds of processor, normalised, of the verdict of each exercise: as many right ones as wrong ones."""
    found = measured(rounds, EXERCISES)
    spent = [median(one.trusted) + median(one.child) for one in found.counted[1:]]
    pairs = zip(EXERCISES, spent[::2], spent[1::2], strict=True)
    return {name: (right + wrong) / 2 * found.pace.processor / 1000 for name, right, wrong in pairs}


def rows(rounds: int) -> list[Row]:
    price, cold = Price.read(), cold_interpreter()
    others = {"a cold interpreter with NumPy": cold, **{f"a container, {on}": s for on, s in price.containers.items()}}
    told = ", ".join(f"{name} {figure(price.million(seconds))} €" for name, seconds in others.items())
    return [
        Row(f"a million gradings of {name}, right and wrong", "€", price.million(seconds), peers=told)
        for name, seconds in verdicts(rounds).items()
    ]


def main() -> None:
    print(table(("", "euros", "beside"), [(one.subject, figure(one.measured or 0.0), one.peers) for one in rows(30)]))


if __name__ == "__main__":
    main()
