"""Five lessons at once, of 300 students each: how long a teacher's page takes to show a verdict, and what pages cost.

    PYTHONPATH=. python tests/benchmarks/bench_lessons.py [--lessons 5] [--students 300] [--seconds 40] [--pause 120]
        [--boards 0] [--beside CHECKOUT]

Each student sends a program every `--pause` seconds on average, half of them right, and follows it to its verdict; the
teacher of each class has « La séance » open on its live stream. The lag of a right program is from the time when its
verdict was ready, as the server has written it, until the stream brings the number of who has solved the exercise with
it. `--boards`: of so many classes somebody follows the board too. Then the pages of one of these classes over HTTP, by
the processor of the server's process: as they are, and right after a student's verdict, which all of them show.

`--beside`: another checkout, with the same database. Its lessons are given after ours, and its pages asked for in turn
with ours: the ratio of the two means something on a busy machine too.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import re
import shutil
import sqlite3
import tempfile
import time
from bisect import insort
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from copy import deepcopy
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from random import Random
from uuid import UUID

from server.base.http import SESSION_COOKIE
from server.course import load_course
from tests.benchmarks.bench_http import PROJECT, serving
from tests.benchmarks.bench_pages import ACCEPT, GOALS, WARM_UP, Outside, clock_of, timed
from tests.benchmarks.crowd.browser import Browser
from tests.benchmarks.crowd.people import programs
from tests.benchmarks.crowd.plan import MODULE, Programs
from tests.benchmarks.crowd.student import raise_limit
from tests.benchmarks.footprint import descendants, footprint
from tests.benchmarks.lesson_classes import TODAY, Lesson, prepared
from tests.benchmarks.light import settle, spent
from tests.benchmarks.measure import Goal, Pace, Row, figure, median, p95, table

LESSONS, STUDENTS, SECONDS, PAUSE = 5, 300, 40.0, 120.0
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


async def watch(address: str, lesson: Lesson) -> None:
    """The teacher's page: notes when it is shown how many have solved each exercise."""
    browser = Browser((address,), lesson.teacher)
    await browser.get(f"/classes/{lesson.class_id}/seance")
    async for name, text in browser.follow(f"/classes/{lesson.class_id}/seance/evenements"):
        parts = json.loads(text) if name == "parts" else {}
        for slug, solved in zip(TODAY, SOLVED.findall(parts.get("days", "")), strict=False):
            lesson.shown[slug].append((int(solved), time.time()))


async def watch_board(address: str, lesson: Lesson) -> None:
    async for _ in Browser((address,), lesson.teacher).follow(f"/classes/{lesson.class_id}/evenements"):
        pass


async def work(address: str, lesson: Lesson, sent: Mapping[str, Programs], seconds: float, rate: float) -> int:
    """The students of a class: `rate` programs a second, of a student each. Return how many they sent."""
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
    return number


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
    address: str, lessons: Sequence[Lesson], sent: Mapping[str, Programs], seconds: float, rate: float, boards: int
) -> int:
    """Return how many programs were sent."""
    watchers = [asyncio.create_task(watch(address, lesson)) for lesson in lessons]
    watchers += [asyncio.create_task(watch_board(address, lesson)) for lesson in lessons[:boards]]
    counts = await asyncio.gather(*(work(address, lesson, sent, seconds, rate) for lesson in lessons))
    await asyncio.sleep(LAST_EVENTS)
    for watcher in watchers:
        if watcher.done():
            raise RuntimeError(f"the page of a lesson is not live any more: {watcher.exception()}")
        watcher.cancel()
    return sum(counts)


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


@dataclass
class Service:
    """A server whose lessons are over. `lags`: seconds; `parts`: milliseconds of processor that a send costs each part;
    `memory`: MB of the web process, and of all. `pages`: milliseconds of processor, as they are and after a verdict."""

    name: str
    address: str
    pid: int
    lessons: Sequence[Lesson]
    lags: Sequence[float]
    sends: int
    parts: Mapping[str, float]
    memory: tuple[float, float]
    pages: dict[str, list[float]] = field(default_factory=dict)
    fresh_pages: dict[str, list[float]] = field(default_factory=dict)


@dataclass(frozen=True)
class Asked:
    """What is measured. `beside`: another checkout."""

    lessons: int = LESSONS
    students: int = STUDENTS
    seconds: float = SECONDS
    pause: float = PAUSE
    rounds: int = 10
    boards: int = 0
    beside: Path | None = None


@dataclass(frozen=True)
class Figures:
    services: Sequence[Service]
    pace: Pace


def give_lessons(name: str, address: str, pid: int, data: Path, lessons: Sequence[Lesson], asked: Asked,
                 sent: Mapping[str, Programs]) -> Service:  # fmt: skip
    settle(pid)
    before, rate = spent(pid), asked.students / asked.pause
    sends = asyncio.run(play(address, lessons, sent, asked.seconds, rate, asked.boards))
    after = spent(pid)
    parts = {part: 1000 * (after[part] - before[part]) / sends for part in after}
    memory = footprint(pid).pss, sum(map(memory_of, (pid, *descendants(pid))))
    return Service(name, address, pid, lessons, lags(data, lessons), sends, parts, memory)


def memory_of(pid: int) -> float:
    """MB of a process; nothing of one that has ended meanwhile."""
    try:
        return footprint(pid).pss
    except OSError:
        return 0.0


def look_at_pages(services: Sequence[Service], sent: Mapping[str, Programs], rounds: int, pace: Pace) -> None:
    """The pages of the first class of each service, in turn: right after a wrong program of a student, and again."""
    draw = Random(1)
    for number in range(WARM_UP + rounds):
        pace.sample()
        for name, path in PATHS.items():
            for service in services:
                lesson = service.lessons[0]
                code = sent[TODAY[0]].drawn(draw, right=False, number=number)
                asyncio.run(send(Browser((service.address,), lesson.students[0]), TODAY[0], code))
                driver, headers = Outside(service.address), {**ACCEPT, "cookie": f"{SESSION_COOKIE}={lesson.teacher}"}
                for found in (service.fresh_pages, service.pages):
                    address = f"/classes/{lesson.class_id}{path}"
                    _, took = timed(lambda: driver.ask(address, headers), clock_of(service.pid))  # noqa: B023
                    if number >= WARM_UP:
                        found.setdefault(name, []).append(took)


def measured(asked: Asked) -> Figures:
    raise_limit()
    course, pace = load_course(render=False), Pace()
    sent, services = programs(course, TODAY), []
    with ExitStack() as stack:
        folders = [Path(stack.enter_context(tempfile.TemporaryDirectory())) for _ in range(1 + bool(asked.beside))]
        lessons = prepared(folders[0], course, asked.lessons, asked.students)
        for folder in folders[1:]:
            shutil.copytree(folders[0], folder, dirs_exist_ok=True)
        checkouts = [("this checkout", PROJECT)]
        if asked.beside is not None:
            checkouts.append(("the other", asked.beside.resolve()))
        for (name, checkout), folder in zip(checkouts, folders, strict=True):
            pace.sample()
            address, pid = stack.enter_context(serving(folder, checkout))
            services.append(give_lessons(name, address, pid, folder, deepcopy(lessons), asked, sent))
            pace.sample()
        look_at_pages(services, sent, asked.rounds, pace)
    return Figures(services, pace)


def longest_page(service: Service) -> tuple[str, float]:
    """Name and milliseconds of the page that takes longest."""
    return max(((name, median(took)) for name, took in service.fresh_pages.items()), key=itemgetter(1))


def rows(asked: Asked) -> list[Row]:
    """The lag of the live pages, and the page of a class that takes longest, by the processor."""
    figures = measured(asked)
    found, by = figures.services[0], figures.pace.wall
    what = f"{asked.lessons} lessons at once, {asked.students} students each"
    told = ", ".join(f"{part} {figure(taken)} ms" for part, taken in found.parts.items())
    middle, late, most = median(found.lags), p95(found.lags), max(found.lags)
    name, longest = longest_page(found)
    normal = longest * figures.pace.processor
    return [
        Row(f"{what}: verdict to the teacher's page, p50", "s", middle, middle * by, peers=f"a send: {told}"),
        Row(f"{what}: verdict to the teacher's page, p95", "s", late, late * by),
        Row(f"{what}: verdict to the teacher's page, most", "s", most, most * by, goal=LAG),
        Row(f"{what}: memory of the web process", "MB", found.memory[0], peers=f"all: {figure(found.memory[1])} MB"),
        Row(
            f"the page of a class of {asked.students} that takes longest, after a verdict: {name}",
            "ms", longest, normal, normal, goal=GOALS["teacher"],
        ),
    ]  # fmt: skip


def report(asked: Asked, found: Figures) -> None:
    pace, services = found.pace, found.services
    print(f"Ten million additions: {0.5 / pace.wall:.3f} s, {0.5 / pace.processor:.3f} s of processor\n")
    lag_rows = []
    for service in services:
        lag = [median(service.lags), p95(service.lags), max(service.lags)]
        lag_rows += [[service.name, str(len(service.lags)), *map(figure, lag)]]
        lag_rows += [["normalised", "", *(figure(each * pace.wall) for each in lag)]]
    print(table(["lag of right verdicts, s", "verdicts", "p50", "p95", "most"], lag_rows))
    columns = [service.name for service in services] + (["ratio"] if len(services) > 1 else [])
    costs = [[part, *_beside([service.parts[part] for service in services])] for part in services[0].parts]
    memory = [
        [f"memory of {what}, MB", *_beside([service.memory[place] for service in services])]
        for place, what in enumerate(("the web process", "all processes"))
    ]
    print(table(["a send, ms of processor", *columns], costs + memory))
    pages = []
    for name in sorted(PATHS, key=lambda name: -median(services[0].fresh_pages[name])):
        for state, of in (("", "pages"), (", after a verdict", "fresh_pages")):
            pages.append([f"{name}{state}", *_beside([median(getattr(service, of)[name]) for service in services])])
    print(table([f"a page of a class of {asked.students}, ms of processor", *columns], pages))
    print(f"normalised: × {pace.processor:.3f}")


def _beside(values: Sequence[float]) -> list[str]:
    """The values, and the ratio of the first to the second where there are two."""
    ratio = [f"{values[0] / values[1]:.2f}"] if len(values) > 1 and values[1] else []
    return [*map(figure, values), *ratio]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--lessons", type=int, default=LESSONS)
    parser.add_argument("--students", type=int, default=STUDENTS)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--pause", type=float, default=PAUSE, help="seconds between two programs of a student")
    parser.add_argument("--rounds", type=int, default=10, help="of the pages")
    parser.add_argument("--boards", type=int, default=0, help="classes whose board is open too")
    parser.add_argument("--beside", type=Path, help="another checkout, measured in turn")
    asked = Asked(**vars(parser.parse_args()))
    report(asked, measured(asked))


if __name__ == "__main__":
    main()
