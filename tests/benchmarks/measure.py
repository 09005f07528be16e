"""Interleaved rounds (A B C, A B C, …), so that noise hits every contender alike; medians, p95, tables.

What a machine is worth just now is told by additions, by which figures of several moments are brought to one.
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
