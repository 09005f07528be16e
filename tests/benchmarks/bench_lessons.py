"""Five lessons at once, of 300 students each: how long a teacher's page takes to show a verdict, and what pages cost.

    PYTHONPATH=. python tests/benchmarks/bench_lessons.py [--lessons 5] [--students 300] [--seconds 40] [--pause 120]

Each student sends a program every `--pause` seconds on average, half of them right, and follows it to its verdict; the
teacher of each class has « La séance » open on its live stream. The lag of a right program is from the time when its
verdict was ready, as the server has written it, until the stream brings the number of who has solved the exercise with
it. Then the pages of one of these classes, by the processor: in this process, as `bench_pages.py` does.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import re
import sqlite3
import tempfile
import time
from bisect import insort
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from random import Random
from uuid import UUID

from sqlalchemy import insert

from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.course import Course, load
from server.database import Database, table_of, utc_now
from server.database.migrate import upgrade
from server.identity.models import Account, BrowserSession, Role
from server.identity.secrets import digest, new_token
from server.lesson.models import LiveLesson
from tests.benchmarks.bench_http import serving
from tests.benchmarks.bench_pages import GOALS, Page
from tests.benchmarks.bench_pages import run as run_pages
from tests.benchmarks.crowd.browser import Browser
from tests.benchmarks.crowd.people import programs
from tests.benchmarks.crowd.plan import MODULE, Programs
from tests.benchmarks.crowd.student import raise_limit
from tests.benchmarks.light import settle, spent
from tests.benchmarks.measure import Goal, Pace, Row, figure, median, p95, table
from tests.benchmarks.readers import School
from tests.support.classes import assign, new_class
from tests.support.crowd import lessons as histories
from tests.support.crowd import seated, store

LESSONS, STUDENTS, SECONDS, PAUSE = 5, 300, 40.0, 120.0
TODAY = ("poses", "odometrie", "lidar", "kabsch")
EARLIER = 22  # exercises at which the classes have worked in the weeks before
VERDICT = 4000  # characters of a verdict that no grader gave, about
RIGHT = 0.5
LAST_EVENTS = 10.0  # seconds in which the last verdicts come to the pages
SOLVED = re.compile(r"<strong>(\d+)</strong>/")
LAG = Goal(1.0)
PATHS = {
    "lesson": "/seance",
    "board": "/tableau",
    "students": "/eleves",
    "gradebook": "/carnet",
    "assignments": "/devoirs",
    "objectives": "/objectifs",
    "week": "/semaine",
}


@dataclass
class Lesson:
    """A class whose lesson goes on. `shown`: when each number of solved exercises first came, by exercise."""

    class_id: UUID
    teacher: str
    students: Sequence[str]
    pairs: list[tuple[str, str]]
    shown: dict[str, list[tuple[int, float]]] = field(default_factory=lambda: {slug: [] for slug in TODAY})


def prepared(data: Path, course: Course, count: int, students: int) -> list[Lesson]:
    """Write the database of this folder: so many classes that have worked for weeks, and whose lessons have begun."""
    database = Database(Settings(data_dir=data).url)
    upgrade(database.engine)
    names = [one.id for one in course.modules[MODULE].exercises if one.slug not in TODAY][:EARLIER]
    mistakes = {name: sorted(course.exercises[name].grader.mistake_ids())[:6] for name in names}
    made = [_lesson(database, number, students, names, mistakes) for number in range(count)]
    database.close()
    return made


def _lesson(
    database: Database, number: int, students: int, names: Sequence[str], mistakes: Mapping[str, Sequence[str]]
) -> Lesson:
    now = utc_now()
    with database.write() as db:
        teacher = Account(role=Role.teacher, name=f"Prof {number}")
        db.add(teacher)
    made = new_class(database, teacher, f"Classe {number}")
    accounts = seated(database, made, students, now)
    store(database, histories(accounts, names, mistakes, now - timedelta(days=1), number), VERDICT)
    today = [f"{MODULE}/{slug}" for slug in TODAY]
    assign(database, made, *names, *today, opened=timedelta(days=20), title="Devoir")
    cookies = {account: new_token() for account in (teacher.id, *accounts)}
    with database.write() as db:
        later = now.replace(year=2100)
        sessions = [
            {"token_digest": digest(cookie), "account_id": account, "expires_at": later}
            for account, cookie in cookies.items()
        ]
        db.execute(insert(table_of(BrowserSession)), sessions)
        db.add(LiveLesson(class_id=made.id, exercises=today, started_at=now - timedelta(minutes=20)))
    own = [cookies[account] for account in accounts]
    return Lesson(made.id, cookies[teacher.id], own, [(cookie, slug) for cookie in own for slug in TODAY])


async def watch(address: str, lesson: Lesson) -> None:
    """The teacher's page: notes when it is shown how many have solved each exercise."""
    browser = Browser((address,), lesson.teacher)
    await browser.get(f"/classes/{lesson.class_id}/seance")
    async for name, text in browser.follow(f"/classes/{lesson.class_id}/seance/evenements"):
        parts = json.loads(text) if name == "parts" else {}
        for slug, solved in zip(TODAY, SOLVED.findall(parts.get("days", "")), strict=False):
            lesson.shown[slug].append((int(solved), time.time()))


async def work(address: str, lesson: Lesson, sent: Mapping[str, Programs], seconds: float, rate: float) -> None:
    """The students of a class: `rate` programs a second, of a student each."""
    draw, number, ends = Random(str(lesson.class_id)), 0, time.monotonic() + seconds
    async with asyncio.TaskGroup() as group:
        while (left := ends - time.monotonic()) > 0:
            await asyncio.sleep(min(left, draw.expovariate(rate)))
            place, right, number = draw.randrange(len(lesson.pairs)), draw.random() < RIGHT, number + 1
            cookie, slug = lesson.pairs[place]
            if right:
                lesson.pairs.pop(place)
            code = sent[slug].drawn(draw, right=right, number=number)
            group.create_task(send(Browser((address,), cookie), slug, code))


async def send(browser: Browser, slug: str, code: str) -> None:
    """Raises RuntimeError for what is not accepted, or ends without a verdict."""
    try:
        answer = await browser.post(f"/{MODULE}/exercices/{slug}/soumissions", code=code)
        if answer.status != 202:
            raise RuntimeError(f"{answer.status}: {answer.text[:300]}")
        async for name, data in browser.follow(json.loads(answer.body)["events"]):
            if name == "status" and json.loads(data)["status"] == "done":
                return
        raise RuntimeError("the stream ended without a verdict")
    finally:
        browser.close()


async def play(
    address: str, lessons: Sequence[Lesson], sent: Mapping[str, Programs], seconds: float, rate: float
) -> None:
    watchers = [asyncio.create_task(watch(address, lesson)) for lesson in lessons]
    await asyncio.gather(*(work(address, lesson, sent, seconds, rate) for lesson in lessons))
    await asyncio.sleep(LAST_EVENTS)
    for watcher in watchers:
        if watcher.done():
            raise RuntimeError(f"the page of a lesson is not live any more: {watcher.exception()}")
        watcher.cancel()


def lags(data: Path, lessons: Sequence[Lesson]) -> list[float]:
    """Seconds from each right verdict to the event that counts it. Raises RuntimeError for one that never came."""
    ready = solved_times(data)
    found = []
    for lesson in lessons:
        for slug, shown in lesson.shown.items():
            for place, at in enumerate(ready.get((lesson.class_id, f"{MODULE}/{slug}"), [])):
                seen = next((time for count, time in shown if count > place), None)
                if seen is None:
                    raise RuntimeError(f"the page never showed {place + 1} students who solved {slug}")
                found.append(seen - at)
    return found


def solved_times(data: Path) -> Mapping[tuple[UUID, str], Sequence[float]]:
    """When each right verdict was ready, by class and exercise, the earliest first; each student's first alone."""
    query = (
        "SELECT membership.class_id, submission.exercise, min(julianday(grading.finished_at)) FROM submission "
        "JOIN grading ON grading.id = submission.grading_id "
        "JOIN membership ON membership.account_id = submission.account_id "
        "WHERE grading.outcome = 'ok' GROUP BY membership.class_id, submission.exercise, submission.account_id"
    )
    found: dict[tuple[UUID, str], list[float]] = {}
    with closing(sqlite3.connect(data / "balise.sqlite3")) as database:
        for class_id, exercise, day in database.execute(query):
            insort(found.setdefault((UUID(class_id), exercise), []), (day - JULIAN_EPOCH) * 86400)
    return found


#: The day from which Unix counts, in Julian days.
JULIAN_EPOCH = 2440587.5


@dataclass(frozen=True)
class Figures:
    """`lags`: seconds; `parts`: shares of one processor; `pages`: of one class."""

    lags: Sequence[float]
    parts: Mapping[str, float]
    pages: Sequence[Page]
    pace: Pace


def measured(count: int, students: int, seconds: float, pause: float, rounds: int) -> Figures:
    raise_limit()
    course, pace = load(render=False), Pace()
    sent = programs(course, TODAY)
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder)
        lessons = prepared(data, course, count, students)
        with serving(data) as (address, pid):
            settle(pid)
            pace.sample()
            before, began = spent(pid), time.monotonic()
            asyncio.run(play(address, lessons, sent, seconds, students / pause))
            after, took = spent(pid), time.monotonic() - began
            pace.sample()
        found = lags(data, lessons)
        here, cookies = f"/classes/{lessons[0].class_id}", {"teacher": {SESSION_COOKIE: lessons[0].teacher}}
        pages = [Page(name, "teacher", here + path) for name, path in PATHS.items()]
        read = School(cookies, "", lessons[0].class_id, lessons[0].class_id, (), "")
        run_pages(pages, read, data, course, rounds, pace)
    return Figures(found, {part: (after[part] - before[part]) / took for part in after}, pages, pace)


def rows(count: int, students: int, seconds: float, pause: float, rounds: int) -> list[Row]:
    """The lag of the live pages, and the page of a class that takes longest, by the processor."""
    found = measured(count, students, seconds, pause, rounds)
    by, what = found.pace.wall, f"{count} lessons at once, {students} students each"
    told = ", ".join(f"{part} {figure(100 * share)} %" for part, share in found.parts.items())
    longest = max(found.pages, key=lambda page: median(page.processor))
    spent_there = median(longest.processor)
    normal = spent_there * found.pace.processor
    middle, late = median(found.lags), p95(found.lags)
    return [
        Row(f"{what}: verdict to the teacher's page, p50", "s", middle, middle * by, peers=f"processor: {told}"),
        Row(f"{what}: verdict to the teacher's page, p95", "s", late, late * by, goal=LAG),
        Row(
            f"the page of a class of {students} that takes longest: {longest.name}",
            "ms", spent_there, normal, normal, goal=GOALS["teacher"],
        ),
    ]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--lessons", type=int, default=LESSONS)
    parser.add_argument("--students", type=int, default=STUDENTS)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--pause", type=float, default=PAUSE, help="seconds between two programs of a student")
    parser.add_argument("--rounds", type=int, default=10, help="of the pages")
    asked = parser.parse_args()
    found = measured(asked.lessons, asked.students, asked.seconds, asked.pause, asked.rounds)
    print(f"Ten million additions: {0.5 / found.pace.wall:.3f} s, {0.5 / found.pace.processor:.3f} s of processor\n")
    lag = [median(found.lags), p95(found.lags), max(found.lags)]
    normal = [one * found.pace.wall for one in lag]
    print(table([f"lag of {len(found.lags)} right verdicts, s", "p50", "p95", "most"], [
        ["measured", *map(figure, lag)], ["normalised", *map(figure, normal)],
    ]))  # fmt: skip
    shares = [[part, figure(100 * share)] for part, share in found.parts.items()]
    print(table(["of one processor, %", ""], shares))
    costs = [
        [page.name, figure(median(page.processor)), figure(median(page.processor) * found.pace.processor)]
        for page in sorted(found.pages, key=lambda page: -median(page.processor))
    ]
    print(table([f"a page of a class of {asked.students}, ms of processor", "", "normalised"], costs))


if __name__ == "__main__":
    main()
