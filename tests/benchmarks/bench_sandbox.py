"""What the walls cost: beside a bare fork of the same template, cold interpreters, and other graders, in one run.

    PYTHONPATH=. python tests/benchmarks/bench_sandbox.py [--rounds 200] [--peers-venv PEERS] [--only latency]

Prints Markdown tables. `peers.py` says how to make PEERS; without it, the other graders are left out.
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from server.sandbox import Policy, Sandbox
from server.sandbox.child.walls import WALLS
from server.sandbox.install import find_installation
from tests.benchmarks.footprint import weigh
from tests.benchmarks.measure import Contender, figure, interleave, median, p95, table
from tests.benchmarks.peers import peers
from tests.benchmarks.programs import PROGRAMS, Program
from tests.benchmarks.throughput import KINDS, rate

#: Seconds before each measure: the spare child that the one before has ordered is ready by then.
REST = 0.02
IMPORTS = ("numpy", "scipy")
SECONDS = 4.0
LOADS = ((1, 1), (1, 2), (1, 4), (2, 1), (2, 2))


def arguments(program: Program) -> tuple[Any, ...]:
    given = eval(program.arguments, {"np": np})
    return given if isinstance(given, tuple) else (given,)


def submission(sandbox: Sandbox, program: Program) -> Callable[[], float]:
    """Open, one call, close; returns what the program computed by its own account."""
    source, given = program.timed, arguments(program)

    def action() -> float:
        with sandbox.open(source) as session:
            value: Any = session.call("timed", *given).value
        return float(value[1])

    return action


def ours(stack: ExitStack, program: Program) -> list[Contender]:
    def sandbox(spares: int, lifted: frozenset[str] = frozenset()) -> Sandbox:
        return stack.enter_context(Sandbox({}, Policy(), spares=spares, lifted=lifted))

    return [
        Contender("**Balise, a spare ready**", submission(sandbox(1), program), rest=REST),
        Contender("a bare fork, a spare ready", submission(sandbox(1, WALLS), program), rest=REST),
        Contender("**Balise, no spare**", submission(sandbox(0), program), rest=REST),
        Contender("a bare fork, no spare", submission(sandbox(0, WALLS), program), rest=REST),
    ]


def latency(rounds: int, peers_venv: Path | None) -> None:
    for program in PROGRAMS:
        with ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
            contenders = ours(stack, program)
            binaries = peers_venv / "bin" if peers_venv else Path(sys.executable).parent
            contenders += peers(program, Path(folder), binaries)
            interleave(contenders, rounds)
        report(program, contenders)


def report(program: Program, contenders: Sequence[Contender]) -> None:
    spare, spare_limit, fork, fork_limit = contenders[:4]
    limits = {spare.name: spare_limit, fork.name: fork_limit}
    rows = []
    for one in contenders:
        limit = limits.get(one.name)
        added = [figure(median(one.added)), figure(p95(one.added))] if any(one.own) else ["", ""]
        rows.append(
            [
                one.name,
                figure(median(one.total)),
                figure(p95(one.total)),
                f"{median(one.total) / median(spare.total):.2f}",
                *added,
                f"{median(one.added) / median(limit.added):.2f}" if limit else "",
                str(len(one.total)),
            ]
        )
    own = median([time for one in contenders[:4] for time in one.own])
    print(f"\n{program.name}: open, one call, close; ms (the student's own computing is {figure(own)} of them)\n")
    head = ["", "median", "p95", "× Balise", "added, median", "added, p95", "added, × bare fork", "rounds"]
    print(table(head, rows), flush=True)


def memory() -> None:
    rows = []
    for imports, program in zip(IMPORTS, PROGRAMS, strict=True):
        idle, child = weigh(program, arguments(program), imports)
        rows += [
            [f"idle template, {imports}", *map(figure, (idle.pss, idle.rss, idle.dirty))],
            [f"a child of it, after {program.name}", *map(figure, (child.pss, child.rss, child.dirty))],
        ]
    print("\nMemory, MB\n")
    print(table(["", "proportional (PSS)", "resident (RSS)", "private, written"], rows), flush=True)


def throughput() -> None:
    rows = [
        [f"{processes} × {threads}", *(figure(rate(kind, processes, threads, SECONDS)) for kind in KINDS)]
        for processes, threads in LOADS
    ]
    print("\nThroughput, a second\n")
    print(table(["processes × threads", "bare submissions", "gradings of l20/poses"], rows), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--rounds", type=int, default=200)
    parser.add_argument("--peers-venv", type=Path, help="a virtual environment that holds the other graders")
    parser.add_argument("--only", choices=("latency", "memory", "throughput"))
    options = parser.parse_args()
    if "scipy" not in find_installation().sets:
        raise SystemExit("this benchmark needs scipy")
    print(f"Python {platform.python_version()}, Linux {platform.release()}, {os.cpu_count()} cores")
    parts: dict[str, Callable[[], None]] = {
        "latency": lambda: latency(options.rounds, options.peers_venv),
        "memory": memory,
        "throughput": throughput,
    }
    for name, part in parts.items():
        if options.only in (None, name):
            part()


if __name__ == "__main__":
    main()
