"""Runs benchmarks one after the other, each in a process of its own, and makes one table of their rows.

None may end another: one that fails, is killed or takes too long leaves its reason in its row.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import signal
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.context import ForkProcess
from pathlib import Path

from tests.benchmarks.measure import REFERENCE, Row, figure, table
from tests.benchmarks.parts import DATA, PARTS, Part, Wanted

ROOT = Path(__file__).resolve().parents[2]
HEAD = ("subject", "measured", "normalised", "processor", "limit", "peers", "goal", "met")
#: One processor for each computation, as the sandbox leaves one to a program; libraries read it once, when they load.
QUIET = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
GRACE = 5.0  # seconds
#: Of which a normalised figure tells how long the additions took beside it.
TIMES = frozenset({"s", "ms", "ns a particle"})
Found = list[Row] | str


def perform(part: Part, wanted: Wanted, answer: Connection) -> None:
    """In a process of its own: sends the rows, or why there are none."""
    os.setsid()
    os.dup2(2, 1)  # what a benchmark prints is no row, nor what it starts
    sys.stdout = sys.stderr
    try:
        answer.send(part.rows(wanted))
    except (Exception, SystemExit) as error:
        traceback.print_exc()
        answer.send(f"{type(error).__name__}: {error}".strip().splitlines()[0])


def found_by(part: Part, wanted: Wanted) -> Found:
    """Its rows, or why it failed. All that it has started ends with it."""
    context = multiprocessing.get_context("fork")  # nothing is loaded yet, and no thread runs
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=perform, args=(part, wanted, there))
    sys.stdout.flush()
    process.start()
    there.close()
    try:
        if not here.poll(part.patience):
            return f"took more than {part.patience:g} s"
        found: Found = here.recv()
        return found
    except EOFError:
        process.join(GRACE)
        return f"ended by signal {-code}" if (code := process.exitcode or 0) < 0 else "ended without an answer"
    finally:
        here.close()
        _end(process)


def _end(process: ForkProcess) -> None:
    """With all that it has started and left: they are of its session."""
    assert process.pid
    for number in (signal.SIGTERM, signal.SIGKILL):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        process.join(GRACE)
        if process.exitcode is not None:
            return


def rows_of(parts: Sequence[Part], wanted: Wanted, failed: list[str]) -> Iterator[Row]:
    for part in parts:
        print(f"{part.name} …", file=sys.stderr, flush=True)
        began = time.monotonic()
        found = found_by(part, wanted)
        print(f"{part.name}: {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
        if isinstance(found, str):
            failed.append(part.name)
            yield Row.missing(part.name, f"failed: {found}")
        else:
            yield from found


def line(row: Row) -> list[str]:
    """A row of the table, in the order of its head."""

    def told(value: float | None) -> str:
        return "" if value is None else f"{figure(value)} {row.unit}".strip()

    met = {True: "met", False: "**not met**", None: ""}[row.met]
    measured = told(row.measured) if row.measured is not None else f"not measured: {row.why}"
    goal = "" if row.goal is None else f"{row.goal} {row.unit}".strip()
    peers = " ; ".join(filter(None, (row.peers, row.why if row.measured is not None else "")))
    cells = [row.subject, measured, told(row.normalised), told(row.processor), told(row.limit), peers, goal, met]
    return [cell.replace("|", "\\|").replace("\n", " ") for cell in cells]


def summary(rows: Sequence[Row]) -> str:
    goals = [row for row in rows if row.goal is not None]
    counts = [sum(row.met is outcome for row in goals) for outcome in (True, False, None)]
    return "{} goals met, {} not met, {} not measured".format(*counts)


def weather(rows: Sequence[Row]) -> str:
    """How long the additions took beside these figures, at least and at most. What is normalised at one moment is to be
    compared with another's no further than that: real work is seldom slowed down as much as they are."""
    times = [row for row in rows if row.measured and row.normalised and row.unit in TIMES]
    found = [REFERENCE * row.measured / row.normalised for row in times if row.measured and row.normalised]
    return f"ten million additions: {min(found):.2f} to {max(found):.2f} s" if found else ""


def chosen(words: Sequence[str], *, quick: bool, suite: bool) -> list[Part]:
    """Those that a word names, whatever they take; else all but those that take minutes, which are asked for."""
    if words:
        return [part for part in PARTS if any(word in part.name for word in words)]
    return [part for part in PARTS if (suite or not part.minutes) and not (quick and part.slow)]


def main(words: Sequence[str] | None = None, description: str = "") -> int:
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], metavar="WORD", help=", ".join(part.name for part in PARTS))
    parser.add_argument("--quick", action="store_true", help="fewer rounds, and not what takes more than a minute")
    parser.add_argument("--suite", action="store_true", help="the tests and the checks of the course too: minutes")
    parser.add_argument("--data", type=Path, default=os.environ.get(DATA), help="public data sets")
    parser.add_argument("--lighthouse", type=Path, help="its cli/index.js, of `npm install lighthouse`")
    asked = parser.parse_args(words)
    os.environ.update(QUIET, PYTHONPATH=os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH")))))
    data = Path(asked.data).resolve() if asked.data else None
    os.environ.pop(DATA, None)  # no setting of the service, which refuses what it does not know
    wanted, failed = Wanted(asked.quick, data, asked.lighthouse), list[str]()
    rows = []
    print(table(HEAD, []), end="")
    for row in rows_of(chosen(asked.only, quick=asked.quick, suite=asked.suite), wanted, failed):
        print(f"| {' | '.join(line(row))} |", flush=True)  # at once: what is stopped has told what it knows
        rows.append(row)
    print(f"\n{summary(rows)}", weather(rows), sep="\n")
    return 1 if failed else 0
