"""A crowd of students before a whole service, and what it takes. Run by hand:

    python -m tests.benchmarks.crowd --students 2000 --engine nats --web 2 --workers 2 --seconds 60

It starts the service by itself, makes the accounts, then has each student browse, read, open an exercise, send what is
wrong, then what is right, with pauses; verdicts are waited for on their events, and a teacher's board is open on 35 of
them. All come from one address, as behind a school's. What is counted begins once the ramp is over; failures count from
the first request. `--enter login`: they log in first, in the ramp. `--json` writes what was found to a file, as
`region.py` reads it. Processor times are told as they are, and normalised to a machine where five million additions
take a quarter of a second.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import closing
from pathlib import Path

from server.course import load_course
from server.database import Database
from tests.benchmarks.crowd import cost, people
from tests.benchmarks.crowd.plan import EXERCISES, Person, Plan, Seen
from tests.benchmarks.crowd.report import Report, told
from tests.benchmarks.crowd.service import ENGINES, Service, started
from tests.benchmarks.crowd.student import perform, raise_limit

SHOWN_FAILURES = 8
START = 3.0  # seconds that a process of students takes to be there


def parse(words: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--students", type=int, default=30)
    parser.add_argument("--engine", choices=ENGINES, default="sqlite")
    parser.add_argument("--web", type=int, default=1, help="web processes")
    parser.add_argument("--workers", type=int, default=1, help="graders")
    parser.add_argument("--drivers", type=int, default=1, help="processes that play students")
    parser.add_argument("--boards", type=int, default=1, help="boards that are open, each on 35 students")
    parser.add_argument("--think", type=float, default=20.0, help="mean pause, in seconds; reading takes more")
    parser.add_argument("--ramp", type=float, default=20.0, help="seconds in which all arrive")
    parser.add_argument("--seconds", type=float, default=60.0, help="then so long")
    parser.add_argument("--enter", choices=("session", "guest", "login"), default="session")
    parser.add_argument("--exercises", nargs="+", default=EXERCISES, metavar="SLUG")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    return parser.parse_args(words)


def planned(service: Service, asked: argparse.Namespace) -> Plan:
    course = load_course(render=False)
    with closing(Database(service.url)) as database:
        known, boards = people.enrolled(database, asked.students, with_login=asked.enter == "login")
    guests = [Person()] * asked.students
    return Plan(
        addresses=service.addresses,
        people=guests if asked.enter == "guest" else known,
        programs=people.programs(course, asked.exercises),
        lessons=people.lessons(course),
        think=asked.think,
        ramp=asked.ramp,
        seconds=asked.seconds,
        began=time.monotonic() + START,
        seed=asked.seed,
        password=people.PASSWORD,
        boards=boards[: asked.boards],
    )


def measured(service: Service, asked: argparse.Namespace) -> Report:
    plan = planned(service, asked)
    with multiprocessing.get_context("spawn").Pool(asked.drivers) as pool:
        going = pool.map_async(perform, list(plan.parts(asked.drivers)), chunksize=1)
        time.sleep(max(0.0, plan.began + plan.ramp - time.monotonic()))
        unit, before, busy = cost.calibration(), cost.spent(service), cost.machine()
        time.sleep(max(0.0, plan.began + plan.ramp + plan.seconds - time.monotonic()))
        after, busy = cost.spent(service), cost.machine() - busy
        seen = Seen()
        for one in going.get():
            seen.add(one)
    taken = {part: after[part] - before.get(part, 0.0) for part in after}
    share = plan.seconds / (plan.ramp + plan.seconds)  # of the time that its students have taken
    return Report(vars(asked), seen, taken, seen.processor * share, busy, unit)


def main(words: list[str] | None = None) -> Report:
    asked = parse(words)
    raise_limit()
    with (
        tempfile.TemporaryDirectory(prefix="balise-crowd-") as folder,
        started(asked.engine, asked.web, asked.workers, Path(folder)) as service,
    ):
        report = measured(service, asked)
    print(told(report), flush=True)
    for failure, count in Counter(report.seen.failures).most_common(SHOWN_FAILURES):
        print(f"! {count} × {failure}", file=sys.stderr)
    if asked.json:
        asked.json.write_text(json.dumps(report.figures(), indent=1) + "\n", encoding="utf-8")
    return report


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))  # with all that it has started
    sys.exit(1 if main().seen.failures else 0)
