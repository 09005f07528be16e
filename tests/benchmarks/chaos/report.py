"""The tables of a run."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.benchmarks.chaos.faults import Fault, happened
from tests.benchmarks.chaos.students import Attempt, Failure, Ledger
from tests.benchmarks.measure import figure, median, p95, table

#: A request that fails so long after a fault has ended is put down to it still: processes take a while to start.
AFTERMATH = 10.0


def latency(attempts: Sequence[Attempt]) -> list[float]:
    """Seconds from the first sending to the verdict."""
    return [one.told - one.begun for one in attempts if one.outcome]


def recovery(fault: Fault, ledger: Ledger) -> tuple[float, float] | None:
    """Seconds from a fault to the next verdict, and to the last verdict of what waited as it began; None where nothing
    was sent any more."""
    told = [one.told for one in ledger.attempts if fault.begun < one.told < float("inf")]
    waited = [one.told for one in ledger.waiting_at(fault.begun)]
    if not told or float("inf") in waited:
        return None
    return min(told) - fault.begun, max(waited, default=min(told)) - fault.begun


def blamed(failure: Failure, faults: Sequence[Fault]) -> Fault | None:
    """The fault that began last, of those that a failed request may come from."""
    near = [one for one in faults if one.begun <= failure.when < one.ended + AFTERMATH]
    direct = [one for one in near if one.kind.startswith(("web", "PostgreSQL"))]
    return max(direct or near, key=lambda one: one.begun, default=None)


def of_faults(ledger: Ledger, faults: Sequence[Fault]) -> str:
    failed = Counter(fault.kind if (fault := blamed(one, faults)) else "none" for one in ledger.failures)
    lines = []
    for kind, ones in sorted(happened(faults).items()):
        found = [times for one in ones if (times := recovery(one, ledger)) is not None]
        next_ones, all_ones = [one for one, _ in found] or [0.0], [one for _, one in found] or [0.0]
        times = (median(next_ones), max(next_ones), median(all_ones), max(all_ones))
        lines.append((kind, str(len(ones)), *map(figure, times), str(failed.pop(kind, 0))))
    lines += [(f"(without a fault: {kind})", "", "", "", "", "", str(count)) for kind, count in failed.items()]
    head = ("fault", "times", "next verdict: median", "worst", "all that waited: median", "worst", "failed requests")
    return table(head, lines)


def of_latency(phases: Sequence[tuple[str, Sequence[Attempt]]]) -> str:
    lines = []
    for name, attempts in phases:
        taken = latency(attempts) or [0.0]
        again = sum(one.tries - 1 for one in attempts)
        lines.append((name, str(len(attempts)), *map(figure, (median(taken), p95(taken), max(taken))), str(again)))
    return table(("from sending to verdict, seconds", "sent", "median", "p95", "worst", "sent again"), lines)


def of_failures(failures: Sequence[Failure]) -> str:
    counted = Counter(one.what for one in failures).most_common()
    return ", ".join(f"{what} {count}" for what, count in counted) or "none"


ERROR = re.compile(r"(ERROR|CRITICAL|WARNING)\b(.*)|^(\w+(?:\.\w+)*(?:Error|Exception|Fault)\b.*)")
PARTICULAR = re.compile(r"\b[0-9a-f]{8}-[0-9a-f-]{27}\b|\b\d+\b|0x[0-9a-f]+")


def of_logs(logs: Sequence[Path]) -> Iterator[str]:
    """What was complained of, how often, without what is particular to one time."""
    told: Counter[str] = Counter()
    for log in logs:
        for line in log.read_text(errors="replace").splitlines():
            if ERROR.search(line):
                told[PARTICULAR.sub("…", line)[-180:]] += 1
    return (f"{count:6d} {line}" for line, count in told.most_common(60))
