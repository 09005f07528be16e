"""A soak: hours of simulated lessons, and all that an administrator and a teacher do beside them. Run by hand:

    python -m tests.benchmarks.soak --hours 2 --csv samples.csv

Students of one class browse, read and send, as in the crowd; a board is open. Every `--every` seconds a round of duties
follows: a test is sat, a regrade is applied and undone, pages and files of the gradebook are read, a backup is made.
Memory (proportional set size), open files and the size of the data are sampled meanwhile. Its status is 1 if a request
or a duty failed, or if memory, open files or the data of each grading grew once the service was warm.
"""

from __future__ import annotations

import argparse
import csv
import json
import signal
import sys
import tempfile
import threading
import time
from collections import Counter
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict, astuple, fields
from pathlib import Path

from server.course import load_course
from server.database import Database
from tests.benchmarks.crowd import people
from tests.benchmarks.crowd.plan import EXERCISES, Plan, Seen
from tests.benchmarks.crowd.service import Service, started
from tests.benchmarks.crowd.student import perform, raise_limit
from tests.benchmarks.measure import table
from tests.benchmarks.soak.duties import DUTIES, TESTED, Duties
from tests.benchmarks.soak.samples import Sample, find_growth, take_sample

TESTERS = 5
SHOWN_FAILURES = 20
SAMPLE_EVERY = 20.0  # seconds


def parse(words: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--hours", type=float, default=2.0)
    parser.add_argument("--students", type=int, default=30)
    parser.add_argument("--think", type=float, default=20.0, help="mean pause of a student, in seconds")
    parser.add_argument("--every", type=float, default=240.0, help="seconds from one round of duties to the next")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--csv", type=Path, help="file to which samples are written as they are taken")
    parser.add_argument("--json", type=Path, help="file to which the results are written")
    return parser.parse_args(words)


def prepare(service: Service, options: argparse.Namespace, folder: Path) -> tuple[Plan, Duties]:
    """Enrol a class; its last members sit the tests, the others play in the crowd."""
    course = load_course(render=False)
    programs = people.programs(course, [*EXERCISES, TESTED])
    with closing(Database(service.url)) as database:
        enrolled, boards = people.enrolled(database, options.students + TESTERS, with_login=False)
    plan = Plan(
        addresses=service.addresses,
        people=enrolled[TESTERS:],
        programs={slug: programs[slug] for slug in EXERCISES},
        lessons=people.lessons(course),
        think=options.think,
        ramp=options.think,
        seconds=3600.0 * options.hours,
        began=time.monotonic(),
        seed=options.seed,
        boards=boards[:1],
    )
    testers = [person.cookie for person in enrolled[:TESTERS]]
    return plan, Duties(service, folder, boards[0], testers, programs)


def sample_until(stop: threading.Event, service: Service, data: Path, path: Path | None) -> list[Sample]:
    """Take samples until the event; write each at once, so that a run that is stopped leaves them."""
    samples: list[Sample] = []
    began = time.monotonic()
    while not stop.wait(SAMPLE_EVERY):
        samples.append(take_sample(service, data, time.monotonic() - began))
        if path:
            with path.open("w" if len(samples) == 1 else "a", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, list(asdict(samples[-1])))
                if len(samples) == 1:
                    writer.writeheader()
                writer.writerow(asdict(samples[-1]))
    return samples


def run(service: Service, options: argparse.Namespace, folder: Path) -> tuple[Seen, Duties, list[Sample]]:
    plan, duties = prepare(service, options, folder)
    stop = threading.Event()
    with ThreadPoolExecutor(2) as pool:
        crowd: Future[Seen] = pool.submit(perform, plan)
        sampling = pool.submit(sample_until, stop, service, folder / "web0" / "data", options.csv)
        while plan.began + plan.ramp + plan.seconds - time.monotonic() > options.every:
            time.sleep(options.every)
            duties.perform_all()
        seen = crowd.result()
        stop.set()
        return seen, duties, sampling.result()


def report(seen: Seen, duties: Duties, samples: list[Sample]) -> list[str]:
    """Print tables; return the faults."""
    names = [field.name for field in fields(Sample)]
    rows = [[f"{value:.0f}" for value in astuple(sample)] for sample in samples[:: max(1, len(samples) // 12)]]
    print(table(names, rows))
    print(f"{seen.requests} requests of students, {len(seen.failures)} failed; {seen.board_events} events of the board")
    for name, count in duties.done.items():
        print(f"{count} × {name}")
    faults = [f"{count} × {failure}" for failure, count in Counter(seen.failures + duties.failures).most_common()]
    faults += [f"never done: {name}" for name in DUTIES if not duties.done[name]]
    return faults + find_growth(samples)


def main(words: list[str] | None = None) -> list[str]:
    options = parse(words)
    raise_limit()
    with tempfile.TemporaryDirectory(prefix="balise-soak-") as name:
        folder = Path(name)
        with started("sqlite", 1, options.workers, folder) as service:
            seen, duties, samples = run(service, options, folder)
    faults = report(seen, duties, samples)
    for fault in faults[:SHOWN_FAILURES]:
        print(f"! {fault}", file=sys.stderr)
    if options.json:
        figures = {"samples": [asdict(sample) for sample in samples], "requests": seen.requests, "faults": faults}
        options.json.write_text(json.dumps({**figures, "duties": duties.done}, indent=1) + "\n", encoding="utf-8")
    return faults


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("stopped"))  # its service stops with it
    sys.exit(1 if main() else 0)
