"""Time that the server takes to read and to draw the board of a class, by its size. Run by hand:

python tests/benchmarks/board.py --rounds 20

Times are of the processor, in this process, which reads, reckons and draws; those of a shared machine mean little all
the same: beside each stands what a fixed computation took in the same rounds, and the ratio of the two.
"""

from __future__ import annotations

import argparse
import hashlib
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from server.app import create_app
from server.base.app_services import get_service
from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.board import repository, service
from server.course import Course, load_course
from server.database import Database, utc_now
from server.database.migrate import upgrade
from server.identity.models import Account, BrowserSession, Role
from server.identity.secrets import draw_secret_token, sha256_hex
from tests.benchmarks.measure import figure, median, p95, table
from tests.support.classes import new_class
from tests.support.client import TestClient
from tests.support.crowd import lessons, seated, store

MODULE = "l20"
SIZES = ((40, 26), (200, 26), (800, 26))
VERDICT = 4000  # characters of a verdict, about
CALIBRATION = 40_000  # digests


def calibration() -> None:
    for number in range(CALIBRATION):
        hashlib.sha256(number.to_bytes(4, "big")).digest()


def timed(action: Callable[[], object]) -> float:
    """Milliseconds of the processor."""
    began = time.process_time()
    action()
    return 1000 * (time.process_time() - began)


def widened(course: Course, module: str, exercises: int) -> Course:
    """The course, with so many exercises in the module: some of them under a second name where it has fewer."""
    served = course.modules[module]
    more = [replace(one, slug=f"{one.slug}_bis") for one in served.exercises[: exercises - len(served.exercises)]]
    wide = replace(served, exercises=(*served.exercises, *more)) if exercises > len(served.exercises) else served
    return replace(course, modules={**course.modules, module: wide})


@contextmanager
def site(data: Path, course: Course) -> Iterator[tuple[TestClient, Database, Account]]:
    settings = Settings(data_dir=data, workers=0, warm_figures=False)
    database = Database(settings.sqlalchemy_url)
    upgrade(database.engine)
    database.close()
    app = create_app(settings, course=course)
    with TestClient(app) as client:
        database, cookie = get_service(app, Database), draw_secret_token()
        with database.write() as db:
            teacher = Account(role=Role.teacher, name="Banc")
            db.add(teacher)
            db.flush()
            later = utc_now().replace(year=2100)
            db.add(BrowserSession(token_digest=sha256_hex(cookie), account_id=teacher.id, expires_at=later))
        client.cookies.set(SESSION_COOKIE, cookie)
        yield client, database, teacher


def contenders(
    client: TestClient, database: Database, course: Course, teacher: Account, students: int, exercises: int
) -> tuple[dict[str, Callable[[], object]], int]:
    made = new_class(database, teacher, f"{students} élèves")
    names = [one.id for one in course.modules[MODULE].exercises][:exercises]
    mistakes = {name: sorted(course.exercises[name].grader.mistake_ids())[:6] for name in names}
    attempts = lessons(seated(database, made, students), names, mistakes, utc_now())
    store(database, attempts, VERDICT)

    def read() -> None:
        with database.read() as db:
            service.load_board(db, course, made, utc_now())

    def pulse() -> None:
        with database.read() as db:
            repository.load_class_version_tag(db, made.id)

    size = f"{students} × {len(names)}"
    actions = {
        f"{size}, page": partial(client.get, f"/classes/{made.id}"),
        f"{size}, board alone (live)": read,
        f"{size}, pulse (live, nothing new)": pulse,
        "calibration": calibration,
    }
    return actions, len(attempts)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=20)
    arguments = parser.parse_args()
    course = widened(load_course(render=False), MODULE, max(exercises for _, exercises in SIZES))
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for students, exercises in SIZES:
            with site(Path(folder) / str(students), course) as (client, database, teacher):
                actions, attempts = contenders(client, database, course, teacher, students, exercises)
                seen: dict[str, list[float]] = {name: [] for name in actions}
                for number in range(1 + arguments.rounds):
                    for name, action in actions.items():
                        took = timed(action)
                        seen[name] += [took] if number else []
                unit = median(seen.pop("calibration"))
                for name, times in seen.items():
                    figures = (median(times), p95(times), unit, median(times) / unit)
                    rows.append([name, str(attempts), *map(figure, figures)])
    print(table(["what", "attempts", "p50 (ms)", "p95 (ms)", "calibration (ms)", "ratio"], rows))


if __name__ == "__main__":
    main()
