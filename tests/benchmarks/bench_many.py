"""Verdicts a second through HTTP, by many students at once who send again as soon as they are answered, on SQLite.

    PYTHONPATH=. python tests/benchmarks/bench_many.py [l20/poses] [--students 8] [--seconds 20] [--right 0.6]

Of what is sent, the solution is the share `--right`; the rest are in turn the catalogued mistakes of the exercise, and
a file that does not load. The client is sockets in this process; its processor time is told apart, and so is that of
each part of the service. The rate that two processors free of the client would give is told from the processor time of
a verdict, and normalised by ten million additions, whose own processor time is measured before and after.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from graders.core.code.grading import CodeGrader
from server.course import load_course
from tests.benchmarks.bench_http import REFERENCE, serving, token_of
from tests.benchmarks.light import Line, crowd, settle, spent
from tests.benchmarks.measure import additions, figure, median, p95, table

EXERCISE, STUDENTS, SECONDS, RIGHT = "l20/poses", 8, 20.0, 0.6
BROKEN = "def composer(p, q:\n    return p\n"
PROCESSORS, MEASURED, TIMES, WARM_UP = 2, 1_000_000, 10, 3.0


@dataclass(frozen=True)
class Many:
    """Of one run: verdicts a second, the milliseconds that each took, those of processor that one costs, by part and of
    the client, and how long ten million additions take of it. `named`: the share whose mistake was named."""

    rate: float
    taken: Sequence[float]
    parts: Mapping[str, float]
    client: float
    processor: float
    right: float
    named: float

    @property
    def cost(self) -> float:
        return sum(self.parts.values())

    @property
    def by_processor(self) -> float:
        return REFERENCE / self.processor

    @property
    def possible(self) -> float:
        """Verdicts a second on two processors that do nothing else, normalised."""
        return 1000 * PROCESSORS / (self.cost * self.by_processor)


def mixed(solution: str, mistakes: Sequence[str], right: float) -> list[str]:
    """Files in the order in which they are sent, over and over: right ones evenly among the others."""
    share = Fraction(right).limit_denominator(20)
    others = [*mistakes, BROKEN]
    files: list[str] = []
    for number in range(share.denominator * len(others)):
        due = (number + 1) * share // 1 - number * share // 1
        files.append(solution if due else others[(number - int(number * share // 1)) % len(others)])
    return files


def measured(
    exercise: str = EXERCISE, students: int = STUDENTS, seconds: float = SECONDS, right: float = RIGHT
) -> Many:
    """On a server of its own, which has warmed up."""
    grader = load_course(render=False).exercises[exercise].grader
    assert isinstance(grader, CodeGrader)
    files = mixed(grader.solution, [one.source for one in grader.misconceptions], right)
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder)) as (address, pid):
        lines = [Line(address, token_of(address, f"banc{number}")) for number in range(students)]
        requests = [[line.request(exercise, file) for file in files] for line in lines]
        sent = [number * len(files) // students for number in range(students)]
        ends = 0.0

        def next_request(number: int) -> bytes | None:
            if time.monotonic() >= ends:
                return None
            sent[number] += 1
            return requests[number][sent[number] % len(files)]

        settle(pid)
        ends = time.monotonic() + WARM_UP
        for _ in crowd(lines, next_request):
            pass
        units = [additions(MEASURED)[1] for _ in range(5)]
        before, mine, began = spent(pid), time.process_time(), time.monotonic()
        ends = began + seconds
        answers = list(crowd(lines, next_request))
        took, mine, after = time.monotonic() - began, time.process_time() - mine, spent(pid)
        units += [additions(MEASURED)[1] for _ in range(5)]
        for line in lines:
            line.close()
    verdicts = [answer.json()["verdict"] for answer in answers]
    count = len(verdicts)
    return Many(
        rate=count / took,
        taken=[1000 * (answer.ended - answer.began) for answer in answers],
        parts={part: 1000 * (after[part] - before[part]) / count for part in after},
        client=1000 * mine / count,
        processor=1000 * TIMES * median(units),
        right=sum(one["score"] == 1 for one in verdicts) / count,
        named=sum(one["diagnosis"] is not None for one in verdicts) / count,
    )


def report(exercise: str, students: int, found: Many) -> None:
    by = found.by_processor
    print(f"Ten million additions: {found.processor:.0f} ms of processor\n")
    mix = f"{found.right:.0%} right, {found.named:.0%} wrong and named, the rest wrong or broken"
    print(f"{students} students, `{exercise}`: {mix}\n")
    times = f"{figure(median(found.taken))} ms, p95 {figure(p95(found.taken))}"
    rows = [["verdicts a second, the client beside", figure(found.rate)]]
    rows += [["a verdict, while others wait", times]]
    rows += [["verdicts a second, of two processors free of it, normalised", figure(found.possible)]]
    print(table(["", ""], rows))
    costs = {**found.parts, "all of the service": found.cost, "the client": found.client}
    told = [[part, figure(taken), figure(taken * by)] for part, taken in costs.items()]
    print(table(["processor, ms a verdict", "", "normalised"], told))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("exercise", nargs="?", default=EXERCISE)
    parser.add_argument("--students", type=int, default=STUDENTS)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--right", type=float, default=RIGHT, help="the share that is right")
    options = parser.parse_args()
    report(
        options.exercise,
        options.students,
        measured(options.exercise, options.students, options.seconds, options.right),
    )


if __name__ == "__main__":
    main()
