"""Time that the server takes for each page to read, of whoever reads it, in a class of 35 with 26 exercises. By hand:

    PYTHONPATH=. python tests/benchmarks/bench_pages.py [--rounds 40] [--only WORD]

Each page as a browser asks for it (compressed), in two ways: in this process, from the request to its answer, of the
wall and of the processor; and over HTTP to `balise serve` on a connection that is kept, where the processor's time is
that of the server's process. `again`: of the wall, for a browser that has the page already and is told so (304).
Times are medians in milliseconds, and 95th percentiles; normalised: divided by what ten million additions in plain
Python take in the same seconds (by the same clock), and multiplied by 500 ms. Pages take turns, so that noise hits all.
"""

from __future__ import annotations

import argparse
import asyncio
import gc
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.client import HTTPConnection
from pathlib import Path
from urllib.parse import urlsplit

from fastapi import FastAPI

from server.app import create_app
from server.base.settings import Settings
from server.course import load_course
from server.course.models import Course
from tests.benchmarks.bench_http import serving
from tests.benchmarks.measure import Goal, Pace, Row, figure, median, p95, table
from tests.benchmarks.readers import EXERCISE, MODULE, QUIZ, School, attempts, school

WARM_UP = 2
#: Milliseconds of processor, normalised, for each reader.
GOALS = {"visitor": Goal(10), "student": Goal(10), "teacher": Goal(30)}
ACCEPT = {"accept-encoding": "gzip, deflate, br, zstd", "accept": "text/html", "user-agent": "bench"}


@dataclass
class Page:
    """One page, as one person asks for it; times in milliseconds."""

    name: str
    who: str
    path: str
    bytes: int = 0
    sent: int = 0
    tag: str = ""
    wall: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)
    http: list[float] = field(default_factory=list)
    server: list[float] = field(default_factory=list)
    again: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class Answer:
    status: int
    headers: Mapping[str, str]
    body: bytes


def pages(course: Course, made: School, attempt: str) -> list[Page]:
    """Of each kind one, of the lessons the longest of its kind."""
    module, here = course.modules[MODULE], f"/classes/{made.class_id}"
    longest = {one.kind.name: one for one in sorted(module.lessons, key=lambda one: len(one.html))}
    mistake = f"{here}/erreurs/{EXERCISE}/{made.mistake}"
    common = [
        ("home", "/"),
        ("module", f"/{MODULE}"),
        *((kind, f"/{MODULE}/lire/{one.slug}") for kind, one in longest.items()),
        ("glossary", f"/{MODULE}/glossaire"),
        ("search", f"/{MODULE}/recherche?q=particules"),
        ("exercise", f"/{MODULE}/exercices/{EXERCISE.partition('/')[2]}"),
    ]
    own = [
        ("quiz", f"/{MODULE}/exercices/{QUIZ.partition('/')[2]}"),
        ("attempts", f"/{MODULE}/exercices/{EXERCISE.partition('/')[2]}/essais"),
        ("attempt, failed", f"/soumissions/{attempt}"),
        ("its verdict alone", f"/soumissions/{attempt}/verdict"),
        ("class", here),
        ("account", "/compte"),
    ]
    taught = [
        ("classes", "/classes"),
        ("board", here),
        ("assignments", f"{here}/devoirs"),
        ("assignment", f"{here}/devoirs/{made.assignments[0]}"),
        ("assignment, form", f"{here}/devoirs/{made.assignments[0]}/modifier"),
        ("gradebook", f"{here}/carnet"),
        ("student", f"{here}/eleves/{made.student}"),
        ("student’s work", f"{here}/eleves/{made.student}/{EXERCISE}"),
        ("attempt, failed", f"/soumissions/{attempt}"),
        ("students", f"{here}/eleves"),
        ("mistake", mistake),
        ("questions", f"{here}/questions"),
        ("predictions", f"{here}/previsions"),
        ("log", f"{here}/journal"),
        ("settings", f"{here}/reglages"),
    ]
    shared = [Page(name, who, path) for who in made.cookies for name, path in common]
    return [
        *shared,
        *(Page(name, "student", path) for name, path in own),
        *(Page(name, "teacher", path) for name, path in taught),
        Page("replay, its data", "visitor", f"/{MODULE}/rejeux/lidar"),
    ]


class Inside:
    """The application in this process, asked without a network."""

    def __init__(self, app: FastAPI, loop: asyncio.AbstractEventLoop) -> None:
        self._app, self._loop = app, loop

    def ask(self, path: str, headers: Mapping[str, str]) -> Answer:
        return self._loop.run_until_complete(self._ask(path, headers))

    async def _ask(self, path: str, headers: Mapping[str, str]) -> Answer:
        address, _, query = path.partition("?")
        told = [(name.encode(), value.encode()) for name, value in {"host": "bench", **headers}.items()]
        scope = {
            "type": "http", "http_version": "1.1", "method": "GET", "path": address, "raw_path": address.encode(),
            "root_path": "", "scheme": "http", "query_string": query.encode(), "headers": told,
            "client": ("127.0.0.1", 1), "server": ("bench", 80), "state": {},
        }  # fmt: skip
        sent: list[dict[str, object]] = []

        async def receive() -> dict[str, object]:
            return {"type": "http.request", "body": b"", "more_body": False}

        async def send(message: dict[str, object]) -> None:
            sent.append(message)

        await self._app(scope, receive, send)  # type: ignore[arg-type]
        start, *parts = sent
        found = {name.decode(): value.decode() for name, value in start["headers"]}  # type: ignore[attr-defined]
        return Answer(int(str(start["status"])), found, b"".join(bytes(part.get("body", b"")) for part in parts))  # type: ignore[call-overload]


@contextmanager
def inside(data: Path, course: Course) -> Iterator[Inside]:
    loop = asyncio.new_event_loop()
    app = create_app(Settings(data_dir=data, workers=0, warm_figures=False), course=course)
    lifespan = app.router.lifespan_context(app)
    loop.run_until_complete(lifespan.__aenter__())
    gc.freeze()  # as `serve` does: what is loaded stays
    try:
        yield Inside(app, loop)
    finally:
        loop.run_until_complete(lifespan.__aexit__(None, None, None))
        loop.close()


class Outside:
    """A server, on one connection that is kept."""

    def __init__(self, address: str) -> None:
        self._connection = HTTPConnection(urlsplit(address).netloc, timeout=60)

    def ask(self, path: str, headers: Mapping[str, str]) -> Answer:
        self._connection.request("GET", path, headers=dict(headers))
        answer = self._connection.getresponse()
        return Answer(answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read())


def clock_of(pid: int) -> int:
    """The clock of the processor time that all the threads of a process have taken (clock_getcpuclockid)."""
    return (~pid << 3) | 2


def headers_of(page: Page, made: School) -> dict[str, str]:
    cookie = "; ".join(f"{name}={value}" for name, value in made.cookies[page.who].items())
    return {**ACCEPT, **({"cookie": cookie} if cookie else {})}


def look(page: Page, made: School, driver: Inside | Outside) -> None:
    """What the page weighs, and its tag."""
    headers = headers_of(page, made)
    plain = driver.ask(page.path, {**headers, "accept-encoding": "identity"})
    answer = driver.ask(page.path, headers)
    assert (plain.status, answer.status) == (200, 200), (page.name, page.who, page.path, answer.status)
    page.bytes, page.sent, page.tag = len(plain.body), len(answer.body), answer.headers.get("etag", "")


def timed(action: Callable[[], Answer], clock: int) -> tuple[float, float]:
    wall, processor = time.perf_counter(), time.clock_gettime_ns(clock)
    action()
    return 1000 * (time.perf_counter() - wall), (time.clock_gettime_ns(clock) - processor) / 1e6


def run(everything: list[Page], made: School, data: Path, course: Course, rounds: int, pace: Pace) -> None:
    with inside(data, course) as driver:
        for number in range(WARM_UP + rounds):
            pace.sample()
            for page in everything:
                headers = headers_of(page, made)
                wall, processor = timed(lambda: driver.ask(page.path, headers), time.CLOCK_PROCESS_CPUTIME_ID)  # noqa: B023
                if number >= WARM_UP:
                    page.wall.append(wall)
                    page.processor.append(processor)


def over_http(everything: list[Page], made: School, address: str, pid: int, rounds: int, pace: Pace) -> None:
    driver, clock = Outside(address), clock_of(pid)
    for number in range(WARM_UP + rounds):
        pace.sample()
        for page in everything:
            headers = headers_of(page, made)
            if not page.sent:
                look(page, made, driver)
            wall, processor = timed(lambda: driver.ask(page.path, headers), clock)  # noqa: B023
            again = None
            if page.tag:
                known = {**headers, "if-none-match": page.tag}
                again, _ = timed(lambda: driver.ask(page.path, known), clock)  # noqa: B023
            if number >= WARM_UP:
                page.http.append(wall)
                page.server.append(processor)
                page.again += [] if again is None else [again]


@dataclass(frozen=True)
class Figures:
    pages: list[Page]
    pace: Pace


def measured(rounds: int, only: str = "") -> Figures:
    course, pace = load_course(render=False), Pace()
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder)
        made = school(data, course)
        with serving(data) as (address, pid):
            everything = [
                one for one in pages(course, made, attempts(address, made)) if only in f"{one.who} {one.name}"
            ]
            over_http(everything, made, address, pid, rounds, pace)
        run(everything, made, data, course, rounds, pace)
    return Figures(everything, pace)


def rows(rounds: int) -> list[Row]:
    """The page that takes longest, of each who reads, by the processor: a page waits for nothing else, but for others
    on the machine."""
    found = measured(rounds)
    made = []
    for who in dict.fromkeys(page.who for page in found.pages):
        longest = max((page for page in found.pages if page.who == who), key=lambda page: median(page.processor))
        spent = median(longest.processor)
        subject = f"the page that takes a {who} longest: {longest.name}"
        normal = spent * found.pace.processor
        made.append(Row(subject, "ms", spent, normal, normal, goal=GOALS[who]))
    return made


def row(page: Page, pace: Pace) -> list[str]:
    normal = median(page.processor) * pace.processor, median(page.wall) * pace.wall, p95(page.wall) * pace.wall
    times = [median(page.processor), median(page.wall), p95(page.wall), *normal]
    http = [median(page.server), median(page.http), p95(page.http), median(page.again) if page.again else 0.0]
    sizes = f"{page.bytes / 1e3:.0f}", f"{page.sent / 1e3:.0f}"
    return [f"{page.who}: {page.name}", *sizes, *map(figure, times), *map(figure, http)]


HEAD = [
    "page", "kB", "sent", "CPU", "wall", "p95", "CPU norm.", "wall norm.", "p95 norm.", "HTTP CPU", "HTTP", "HTTP p95",
    "again",
]  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=40)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    found = measured(arguments.rounds, arguments.only)
    ordered = sorted(found.pages, key=lambda one: -median(one.processor))
    print(table(HEAD, [row(page, found.pace) for page in ordered]))
    met = sum(GOALS[page.who].met(median(page.processor) * found.pace.processor) for page in found.pages)
    print(f"{met} of {len(found.pages)} pages meet the goal of their reader (processor, normalised)")
    print(f"ten million additions: {0.5 / found.pace.wall:.3f} s")


if __name__ == "__main__":
    main()
