"""What the table of all is made of: one part a benchmark, which gives its rows.

A benchmark is imported by its part alone, in the process that runs it: what it loads, or cannot load, is its own.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.measure import Goal, Pace, Row, figure, median, p95
from tests.support.chromium import chromium

ROOT = Path(__file__).resolve().parents[2]
DATA = "BALISE_DATA"
NO_DATA = f"neither --data nor {DATA} names a folder of data sets"
NO_LIGHTHOUSE = "--lighthouse names no cli/index.js (npm install lighthouse)"


@dataclass(frozen=True)
class Wanted:
    """`quick`: fewer rounds. `data`: public data sets; `lighthouse`: its script; None: there are none here."""

    quick: bool = False
    data: Path | None = None
    lighthouse: Path | None = None

    def rounds(self, usual: int) -> int:
        return max(2, usual // 5) if self.quick else usual


@dataclass(frozen=True)
class Part:
    """`patience`: seconds after which it is given up. `slow`: more than a minute; `minutes`: only where asked for."""

    name: str
    rows: Callable[[Wanted], list[Row]]
    patience: float = 300.0
    slow: bool = False
    minutes: bool = False


def exchange(wanted: Wanted) -> list[Row]:
    from tests.benchmarks.bench_exchange import rows

    return rows(wanted.rounds(60))


def declared(wanted: Wanted) -> list[Row]:
    from tests.benchmarks.bench_declared import rows

    return rows(wanted.rounds(60))


@dataclass(frozen=True)
class Sent:
    """A program sent over HTTP: milliseconds from submitting to the verdict, as they are to be: median and p95.

    The solution, or the file of a catalogued `mistake`. `apart`: these hold for what is left when the program's own
    computing is taken away.
    """

    name: str
    exercise: str
    mistake: str = ""
    middle: Goal | None = None
    late: Goal | None = None
    apart: bool = False


SENT = (
    Sent("l20/poses, right", "l20/poses", "", Goal(15), Goal(35)),
    Sent("l20/poses, wrong and named", "l20/poses", "ordre_echange"),
    Sent("l20/slam_graphe, right", "l20/slam_graphe", "", apart=True),
)
TWICE = Goal(2)  # a wrong answer with its name, by a right one
PAUSE = 0.03  # seconds between a verdict and the next submission


def http(wanted: Wanted) -> list[Row]:
    """Of each program the whole service's processor time too, and what is its own computing."""
    from tests.benchmarks import bench_http as bench

    made, middles = [], []
    for one in SENT:
        code = bench.code_of(one.exercise, one.mistake)
        found = bench.measured(one.exercise, code, wanted.rounds(200), PAUSE, named=one.mistake)
        taken, spent = found.steps[bench.WHOLE], sum(found.parts.values()) * found.by_processor
        own = found.own * found.by_processor
        told = f"of it, {figure(own)} ms of processor are the program's own"
        subject = f"submit to verdict over HTTP, {one.name}"
        whole = (None, None) if one.apart else (one.middle, one.late)
        middles.append(median(taken) * found.by_wall)
        made += [
            Row(f"{subject}: p50", "ms", median(taken), middles[-1], spent, peers=told, goal=whole[0]),
            Row(f"{subject}: p95", "ms", p95(taken), p95(taken) * found.by_wall, goal=whole[1]),
        ]
        if one.apart:
            subject = f"{subject}, without its own computing"
            made += [
                Row(f"{subject}: p50", "ms", median(taken) - found.own, middles[-1] - own, goal=one.middle),
                Row(f"{subject}: p95", "ms", p95(taken) - found.own, p95(taken) * found.by_wall - own, goal=one.late),
            ]
    ratio = middles[1] / middles[0]
    return [*made, Row("submit to verdict over HTTP, l20/poses: wrong ÷ right", "×", ratio, goal=TWICE)]


A_SECOND = Goal(80, at_least=True)


def many(wanted: Wanted) -> list[Row]:
    """Normalised: of two processors that are free of the client."""
    from tests.benchmarks import bench_many as bench
    from tests.benchmarks.euros import Price

    found = bench.measured(seconds=5.0 if wanted.quick else bench.SECONDS)
    cost = found.cost * found.by_processor
    mix = f"{found.right:.0%} right, {found.named:.0%} wrong and named"
    parts = ", ".join(f"{part} {figure(spent * found.by_processor)} ms" for part, spent in found.parts.items())
    of = f"{bench.EXERCISE} through HTTP, {mix}"
    return [
        Row(f"verdicts of {of}", "a second", found.rate, found.possible, peers=f"processor: {parts}", goal=A_SECOND),
        Row(f"a million verdicts of {of}", "€", Price.read().million(cost / 1000)),
    ]


def pages(wanted: Wanted) -> list[Row]:
    from tests.benchmarks import bench_pages

    return bench_pages.rows(wanted.rounds(30))


def lessons(wanted: Wanted) -> list[Row]:
    from tests.benchmarks import bench_lessons as bench

    seconds = 20.0 if wanted.quick else bench.SECONDS
    return bench.rows(bench.Asked(seconds=seconds, rounds=wanted.rounds(10)))


def turns(wanted: Wanted) -> list[Row]:
    from tests.benchmarks import bench_turns

    return bench_turns.rows(wanted.rounds(3))


def paint(wanted: Wanted) -> list[Row]:
    try:
        from tests.benchmarks import bench_paint as bench
    except ImportError as error:
        return [Row.missing("first paint on slow 4G", str(error))]
    if chromium() is None:
        return [Row.missing("first paint on slow 4G", "Chromium is not installed", bench.COLD_GOAL)]
    return bench.rows(wanted.rounds(5))


def scripts(_: Wanted) -> list[Row]:
    from server.web import assets
    from tests.support.scripts import MOST, sent

    subject, goal = "JavaScript of an exercise's page, compressed", Goal(MOST / 1000)
    if not assets.is_frontend_built():
        return [Row.missing(subject, "the front end is not built", goal)]
    return [Row(subject, "kB", sum(sent().values()) / 1000, goal=goal)]


def lighthouse(wanted: Wanted) -> list[Row]:
    from tests.benchmarks import bench_lighthouse as bench

    if wanted.lighthouse is None or not wanted.lighthouse.is_file():
        return [Row.missing("Lighthouse, three pages: least of four marks", NO_LIGHTHOUSE, bench.GOAL)]
    return bench.rows(str(wanted.lighthouse), wanted.rounds(5))


def start(wanted: Wanted) -> list[Row]:
    from tests.benchmarks.bench_start import rows

    return rows(wanted.rounds(10))


def install(_: Wanted) -> list[Row]:
    from tests.benchmarks.bench_install import rows

    return rows()


def pose_graph(wanted: Wanted) -> list[Row]:
    from tests.benchmarks import bench_pose_graph as bench

    folder = wanted.data / "pg2d" if wanted.data else None
    if folder is None or not folder.is_dir():
        named = (
            (f"pose graph {name}: ours ÷ {peer}", goal) for name in bench.SETS for peer, goal in bench.GOALS.items()
        )
        return [Row.missing(subject, NO_DATA, goal) for subject, goal in named]
    return bench.rows(folder, wanted.rounds(9), bench.SETS[:2] if wanted.quick else bench.SETS)


def maps(wanted: Wanted) -> list[Row]:
    if wanted.data:
        os.environ[DATA] = str(wanted.data)
    from tests.benchmarks.bench_maps import rows

    return rows(20_000 if wanted.quick else 100_000, wanted.data)


def mapping(wanted: Wanted) -> list[Row]:
    from tests.benchmarks.bench_slam import rows

    return rows(wanted.data)


def casting(wanted: Wanted) -> list[Row]:
    from tests.benchmarks.bench_raycast import rows

    return rows(wanted.rounds(15))


def filters(wanted: Wanted) -> list[Row]:
    from tests.benchmarks.bench_filters import rows

    return rows(wanted.rounds(30))


def euros(wanted: Wanted) -> list[Row]:
    from tests.benchmarks.euros import rows

    return rows(wanted.rounds(30))


#: What takes minutes: a name, the command, and the seconds that it may take, of the wall, on two processors.
COMMANDS = {
    "the tests": (["-m", "pytest"], Goal(100)),
    "`balise check`": (["-m", "server", "check", "--fresh"], None),
}


def suite(_: Wanted) -> list[Row]:
    return [timed(name, [sys.executable, *words], goal) for name, (words, goal) in COMMANDS.items()]


def timed(name: str, command: list[str], goal: Goal | None) -> Row:
    """Raises RuntimeError, with what it ends by saying, where it does not succeed."""
    pace = Pace()
    pace.sample()
    before, began = os.times(), time.monotonic()
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    wall, after = time.monotonic() - began, os.times()
    pace.sample()
    if done.returncode:
        raise RuntimeError(f"{name}: {(done.stdout + done.stderr).strip()[-300:]}")
    spent = after.children_user - before.children_user + after.children_system - before.children_system
    return Row(name, "s", wall, wall * pace.wall, spent * pace.processor, goal=goal)


PARTS = (
    Part("exchange", exchange),
    Part("declared", declared),
    Part("http", http, patience=600.0),
    Part("many", many, patience=600.0),
    Part("euros", euros),
    Part("pages", pages),
    Part("lessons", lessons, patience=900.0, slow=True),
    Part("turns", turns),
    Part("paint", paint, slow=True),
    Part("scripts", scripts),
    Part("lighthouse", lighthouse, patience=900.0, slow=True),
    Part("start", start),
    Part("install", install, patience=900.0, slow=True),
    Part("pose graph", pose_graph),
    Part("maps", maps, patience=600.0),
    Part("slam", mapping),
    Part("casting", casting),
    Part("filters", filters),
    Part("suite", suite, patience=3600.0, minutes=True),
)
