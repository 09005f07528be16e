"""What a run has found, as tables and as figures for the simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.benchmarks.crowd.cost import normalised
from tests.benchmarks.crowd.plan import Seen
from tests.benchmarks.measure import figure, table

PAGES = ("module", "lesson", "exercise", "verdict page", "board", "static file", "log in")
ORDER = (*PAGES, "submission", "figure", "verdict told", "verdict shown")


@dataclass(frozen=True)
class Report:
    """`taken`: seconds of processor of each part of the service while it was measured; `driver`, of the students;
    `machine`, of all that ran; `unit`, of the calibration."""

    asked: Mapping[str, Any]
    seen: Seen
    taken: Mapping[str, float]
    driver: float
    machine: float
    unit: float

    @property
    def seconds(self) -> float:
        return float(self.asked["seconds"])

    @property
    def verdicts(self) -> int:
        return len(self.seen.times.get("verdict told", ()))

    @property
    def measured(self) -> int:
        """Requests that ended while it was measured; a stream of events is one, whose end is the verdict told."""
        return sum(len(times) for kind, times in self.seen.times.items() if kind != "verdict shown")

    def figures(self) -> dict[str, Any]:
        """For programs: the conditions, milliseconds of each kind, and normalised milliseconds of processor."""
        normal = normalised(self.taken, self.unit)
        return {
            "conditions": {name: str(value) for name, value in self.asked.items() if value is not None},
            "requests_each_second": self.measured / self.seconds,
            "verdicts_each_second": self.verdicts / self.seconds,
            "failures": len(self.seen.failures),
            "milliseconds": {
                kind: [len(times), *percentiles(times)] for kind, times in sorted(self.seen.times.items())
            },
            "calibration_seconds": self.unit,
            "processor_seconds": dict(self.taken),
            "normalised_processor_seconds": normal,
            "driver_processor_seconds": self.driver,
        }


def percentiles(times: Sequence[float]) -> list[float]:
    """Mean, p50, p95, p99 and the longest, in milliseconds."""
    found = [float(np.mean(times)), *map(float, np.percentile(times, [50, 95, 99, 100]))]
    return [1000.0 * one for one in found]


def told(report: Report) -> str:
    asked, seen = report.asked, report.seen
    conditions = (
        f"{asked['students']} students, {asked['engine']}, {asked['web']} web, {asked['workers']} graders; "
        f"mean pause {asked['think']:g} s; {report.seconds:g} s measured, after a ramp of {asked['ramp']:g} s; "
        f"one address; entering by {asked['enter']}"
    )
    counts = (
        f"{seen.requests} requests in all, {len(seen.failures)} failures; measured: {report.measured} requests "
        f"({report.measured / report.seconds:.1f}/s), {report.verdicts} verdicts "
        f"({report.verdicts / report.seconds:.2f}/s); {seen.board_events} events on boards"
    )
    kinds = [kind for kind in ORDER if seen.times.get(kind)]
    rows = [[kind, str(len(seen.times[kind])), *map(figure, percentiles(seen.times[kind]))] for kind in kinds]
    times = table(["milliseconds", "n", "mean", "p50", "p95", "p99", "most"], rows)
    return f"{conditions}\n{counts}\n\n{times}\n{_processor(report)}"


def _processor(report: Report) -> str:
    parts = {**report.taken, "(students)": report.driver}
    normal = normalised(parts, report.unit)
    rows = [
        [
            part,
            figure(taken),
            figure(100 * taken / report.seconds),
            figure(1000 * normal[part] / max(1, report.measured)),
            figure(1000 * normal[part] / max(1, report.verdicts)),
        ]
        for part, taken in parts.items()
    ]
    others = report.machine - sum(parts.values())
    rows.append(["(others on the machine)", figure(others), figure(100 * others / report.seconds), "", ""])
    head = ["processor", "seconds", "% of one", "normalised ms a request", "normalised ms a verdict"]
    return f"{table(head, rows)}calibration: {1000 * report.unit:.0f} ms\n"
