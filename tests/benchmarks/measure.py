"""Interleaved rounds (A B C, A B C, …), so that noise hits every contender alike; medians, p95, tables.

What a machine is worth just now is told by additions, by which figures of several moments are brought to one
(`Pace`). What a benchmark has found is told as `Row`s too, of which `all.py` makes one table.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field


@dataclass
class Contender:
    """Something timed. `action` returns the part of its time that was the student's own computing, in seconds.

    It runs in one round of `every`; `rest` is waited before, untimed.
    """

    name: str
    action: Callable[[], float]
    every: int = 1
    rest: float = 0.0
    total: list[float] = field(default_factory=list)
    own: list[float] = field(default_factory=list)

    def run(self) -> None:
        time.sleep(self.rest)
        start = time.perf_counter()
        own = self.action()
        self.total.append(1000.0 * (time.perf_counter() - start))
        self.own.append(1000.0 * own)

    @property
    def added(self) -> list[float]:
        """Milliseconds beyond the student's own computing."""
        return [total - own for total, own in zip(self.total, self.own, strict=True)]


def interleave(contenders: Iterable[Contender], rounds: int) -> None:
    """Runs them side by side, after one round each that does not count."""
    field_of = list(contenders)
    for contender in field_of:
        contender.action()
    for number in range(rounds):
        for contender in field_of:
            if number % contender.every == 0:
                contender.run()


def additions(count: int) -> tuple[float, float]:
    """Seconds that so many additions take in plain Python: of the wall, and of this thread's processor.

    They are made at the top of a module, where names are slower than in a function.
    """
    loop = compile(f"total = 0\nfor _ in range({count}):\n    total += 1", "additions", "exec")
    wall, processor = time.perf_counter(), time.thread_time()
    exec(loop, {})
    return time.perf_counter() - wall, time.thread_time() - processor


#: What a figure is normalised to: a machine on which so many additions take so many seconds.
ADDITIONS, REFERENCE = 10_000_000, 0.5
SAMPLED = 10  # a tenth of them is timed, again and again


class Pace:
    """What the machine was worth while something was timed: additions, timed beside it in the same seconds."""

    def __init__(self) -> None:
        self.samples: list[tuple[float, float]] = []

    def sample(self) -> None:
        wall, processor = additions(ADDITIONS // SAMPLED)
        self.samples.append((SAMPLED * wall, SAMPLED * processor))

    @property
    def wall(self) -> float:
        """By what a time of the wall is multiplied to be normalised."""
        return REFERENCE / median([wall for wall, _ in self.samples])

    @property
    def processor(self) -> float:
        """The same, of a processor's time, which others on the machine lengthen less."""
        return REFERENCE / median([processor for _, processor in self.samples])


@dataclass(frozen=True)
class Goal:
    """What a figure is to be: at most so much, or at least; the normalised figure, where there is one."""

    bound: float
    at_least: bool = False

    def met(self, value: float) -> bool:
        return value >= self.bound if self.at_least else value <= self.bound

    def __str__(self) -> str:
        return f"{'≥' if self.at_least else '≤'} {self.bound:g}"


@dataclass(frozen=True)
class Row:
    """One figure of the table of all. `measured`, `normalised`, `processor` (which is normalised) and `limit`, the
    least that the same run could have taken, are in `unit`; None: there is none. `why`: why it could not be measured,
    or a peer.
    """

    subject: str
    unit: str
    measured: float | None = None
    normalised: float | None = None
    processor: float | None = None
    limit: float | None = None
    peers: str = ""
    goal: Goal | None = None
    why: str = ""

    @property
    def counts(self) -> float | None:
        """What the goal is held against."""
        return self.measured if self.normalised is None else self.normalised

    @property
    def met(self) -> bool | None:
        """None: there is no goal, or nothing was measured."""
        return None if self.goal is None or self.counts is None else self.goal.met(self.counts)

    @staticmethod
    def missing(subject: str, why: str, goal: Goal | None = None) -> Row:
        return Row(subject, "", goal=goal, why=why)


def median(times: Sequence[float]) -> float:
    return statistics.median(times)


def p95(times: Sequence[float]) -> float:
    return statistics.quantiles(times, n=20, method="inclusive")[-1] if len(times) > 1 else times[0]


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def figure(value: float) -> str:
    """Three significant digits, without an exponent."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"
