"""What a verdict costs beside the limit: a fork behind its walls, and one empty call. In one run, side by side.

    PYTHONPATH=. python tests/benchmarks/bench_exchange.py [--rounds 60] [--exercises l20/poses l20/kabsch] [--strace]

Of each exercise, the solution and a catalogued mistake, which is named. Times are milliseconds, and are also told
normalised: divided by what ten million additions in plain Python take in the same seconds (by its own clock: of the
wall, or of the processor), and multiplied by 500 ms. With `--strace`, the system calls of the trusted side too.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from graders.core.code.grading import CodeGrader
from server.course import load_course
from server.course.models import Course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox
from server.sandbox.process import Child
from server.sandbox.session import Session
from server.sandbox.wire import Wire
from tests.benchmarks.measure import REFERENCE, Goal, Pace, Row, figure, median, p95, table

EXERCISES = ("l20/poses", "l20/predire2d", "l20/kabsch", "l20/slam_graphe")
#: The spare child that the one before has ordered is ready by then.
REST = 0.03
SYSTEM_CALLS = 20
EMPTY = b"def f():\n    return None\n"
#: Of a right answer to the first exercise: exchanges, milliseconds of the trusted side and of the wall; then of any
#: wrong answer, by a right one.
EXCHANGES, WRONG = Goal(4), Goal(2)


@dataclass
class Counted:
    """One kind of submission: what each round took, and of the last one what was exchanged."""

    name: str
    submit: Callable[[int], object]
    wall: list[float] = field(default_factory=list)
    trusted: list[float] = field(default_factory=list)
    child: list[float] = field(default_factory=list)
    exchanges: int = 0
    processes: int = 0

    def run(self, seed: int, watch: Watch) -> None:
        time.sleep(REST)
        with watch.counting():
            wall, processor = time.perf_counter(), time.thread_time()
            self.submit(seed)
            self.trusted.append(1000 * (time.thread_time() - processor))
            self.wall.append(1000 * (time.perf_counter() - wall))
        self.exchanges, self.processes = watch.asked, len(watch.children)
        self.child.append(1000 * sum(child.wait_exit(5.0).cpu_seconds for child in watch.children))


class Watch:
    """Counts the questions that wires carry, and the children whose sessions are closed."""

    def __init__(self) -> None:
        self.asked = 0
        self.children: list[Child] = []

    @contextmanager
    def counting(self) -> Iterator[None]:
        self.asked, self.children = 0, []
        ask, close = Wire.send, Session.close

        def counted(wire: Wire, token: int, kind: int, payload: bytes, deadline: float) -> None:
            self.asked += 1
            ask(wire, token, kind, payload, deadline)

        def closed(session: Session) -> None:
            if session._child not in self.children:
                self.children.append(session._child)
            close(session)

        Wire.send, Session.close = counted, closed  # type: ignore[method-assign]
        try:
            yield
        finally:
            Wire.send, Session.close = ask, close  # type: ignore[method-assign]


def contenders(course: Course, sandbox: Sandbox, exercises: Sequence[str]) -> list[Counted]:
    grader = SandboxGrader(course, sandbox)

    def limit(seed: int) -> None:
        with sandbox.open(EMPTY) as session:
            session.call("f")

    def graded(exercise: str, source: bytes, *, right: bool) -> Callable[[int], object]:
        def submit(seed: int) -> None:
            verdict = grader.grade(exercise, source, seed).verdict
            if (verdict.score == 1) != right or (not right and verdict.diagnosis is None):
                raise RuntimeError(f"{exercise}: {verdict.score}, {verdict.diagnosis}")

        return submit

    made = [Counted("the limit: a fork, its walls, an empty call", limit)]
    for name in exercises:
        of = course.exercises[name].grader
        assert isinstance(of, CodeGrader)
        made.append(Counted(f"`{name}`, right", graded(name, of.solution.encode(), right=True)))
        wrong = of.misconceptions[0].source.encode()
        made.append(Counted(f"`{name}`, wrong and named", graded(name, wrong, right=False)))
    return made


def system_calls(one: Counted) -> str:
    """System calls of this process for one submission, its other threads included."""
    command = ["strace", "-f", "-c", "-p", str(os.getpid())]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as tracer:
        assert tracer.stderr
        tracer.stderr.readline()
        for seed in range(SYSTEM_CALLS):
            one.submit(seed)
        tracer.send_signal(2)
        told = tracer.stderr.read()
    total = re.search(r"^\s*100\.00\s+\S+\s+(?:\d+\s+)?(\d+)\s+(?:\d+\s+)?total", told, re.MULTILINE)
    return str(round(int(total[1]) / SYSTEM_CALLS)) if total else "?"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--rounds", type=int, default=60)
    parser.add_argument("--exercises", nargs="*", default=EXERCISES)
    parser.add_argument("--strace", action="store_true")
    options = parser.parse_args()
    traced = options.strace and shutil.which("strace")
    report(measured(options.rounds, options.exercises, traced=bool(traced)))


@dataclass(frozen=True)
class Found:
    """The limit first, then of each exercise what is right and what is wrong; the system calls of each, if traced."""

    counted: list[Counted]
    calls: list[str]
    pace: Pace


def measured(rounds: int, exercises: Sequence[str], *, traced: bool = False) -> Found:
    course, watch, pace = load_course(render=False), Watch(), Pace()
    with Sandbox(course.kits) as sandbox:
        field_of = contenders(course, sandbox, exercises)
        for one in field_of:
            for seed in range(3):
                one.submit(seed)
        for seed in range(rounds):
            pace.sample()
            for one in field_of:
                one.run(1000 + seed, watch)
        calls = [system_calls(one) if traced else "" for one in field_of]
    return Found(field_of, calls, pace)


def rows(rounds: int) -> list[Row]:
    """In milliseconds. What is asked of one exercise is asked of the first."""
    found = measured(rounds, EXERCISES)
    limit, *graded = found.counted
    made = []
    for one, right in zip(graded, [two for two in graded[::2] for _ in range(2)], strict=True):
        wall, least = median(one.wall), median(limit.wall)
        trusted, child = (median(spent) * found.pace.processor for spent in (one.trusted, one.child))
        of = f"checks of {one.name}"
        if one is graded[0]:
            made += [
                Row(f"{of}: exchanges", "", float(one.exchanges), goal=EXCHANGES),
                Row(f"{of}: trusted processor", "ms", median(one.trusted), trusted),
            ]
        made.append(Row(of, "ms", wall, wall * found.pace.wall, trusted + child, least))
        if one is not right:
            made.append(Row(f"{of} ÷ right", "×", wall / median(right.wall), goal=WRONG))
    return made


def report(found: Found) -> None:
    field_of, calls, pace = found.counted, found.calls, found.pace
    by_wall, by_processor = pace.wall, pace.processor
    limit, rows = median(field_of[0].wall), []
    before = limit
    for one, count in zip(field_of, calls, strict=True):
        spent = median(one.wall)
        rows.append(
            [
                one.name,
                str(one.exchanges),
                str(one.processes),
                count,
                figure(spent),
                figure(p95(one.wall)),
                figure(spent * by_wall),
                f"{spent / limit:.1f}",
                f"{spent / before:.2f}" if "wrong" in one.name else "",
                figure(median(one.trusted)),
                figure(median(one.trusted) * by_processor),
                figure(median(one.child)),
                figure(median(one.child) * by_processor),
            ]
        )
        before = spent
    head = ["", "exchanges", "processes", "system calls", "wall", "p95", "wall, normalised", "× limit", "× right"]
    head += ["trusted CPU", "normalised", "child CPU, its fork included", "normalised"]
    wall, processor = 1000 * REFERENCE / by_wall, 1000 * REFERENCE / by_processor
    print(f"Ten million additions: {wall:.0f} ms of the wall, {processor:.0f} ms of processor\n")
    print(table(head, rows))


if __name__ == "__main__":
    main()
