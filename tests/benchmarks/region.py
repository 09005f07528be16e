"""A region's day before it is bought: what breaks first, who waits how long, what it costs. Run by hand:

    python -m tests.benchmarks.region [--students 50000] [--graders 25 50 100 200] [--crowd RUN.json]

A simulation by discrete events of two moments: a lesson that begins at the hour, and the last half-hour before a
deadline at 23:59. Each request queues for a web process; each submission for the one place where turns are given
(PostgreSQL puts jobs one at a time), for a grader, for the web again, and what is wrong for a picture. Times of
service come from `region.toml`, or from a run of `tests.benchmarks.crowd --json`. The rest of the day is summed up by
its means. `tests/contract/queue/test_region.py` holds it to what queueing theory says.
"""

from __future__ import annotations

import argparse
import heapq
import json
import tomllib
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.benchmarks.measure import figure, table

HOUR = 3600.0
CALIBRATION = Path(__file__).with_suffix(".toml")
#: The stations, as the tables name them.
WEB, LOGIN, PUT, GRADERS, FIGURES = "pages", "connexions", "mise en file", "correcteurs", "figures"
DATABASE, NATS = "PostgreSQL", "NATS"
STATIONS = (WEB, LOGIN, PUT, GRADERS, FIGURES)

#: Of a run: what is no request, and what a browser asks for once in its life.
UNCOUNTED = {"verdict shown", "static file"}

Times = NDArray[np.float64]
#: Which station, and for how many seconds.
Route = Sequence[tuple[str, float]]


@dataclass(frozen=True)
class Costs:
    """Seconds of a processor unless said otherwise; `lesson` and `deadline`: of a grading in each."""

    request: float
    login: float
    put: float
    lesson: float
    deadline: float
    figure: float
    database: float  # a submission
    nats: float  # a submission
    spread: float  # of gradings: standard deviation over mean

    @staticmethod
    def read(path: Path = CALIBRATION, crowd: Path | None = None) -> Costs:
        """`crowd`: of a run, in place of what it has measured."""
        known = tomllib.loads(path.read_text(encoding="utf-8"))["seconds"]
        return Costs(**{**known, **({} if crowd is None else measured(json.loads(crowd.read_text())))})


def price(path: Path = CALIBRATION) -> float:
    return float(tomllib.loads(path.read_text(encoding="utf-8"))["euros"]["processor"])


def measured(run: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """From the figures of a run on PostgreSQL and NATS: normalised seconds of each part, a request or a verdict."""
    kinds = run["milliseconds"]
    requests = sum(seen[0] for kind, seen in kinds.items() if kind not in UNCOUNTED)  # type: ignore[index]
    verdicts = kinds["verdict told"][0]  # type: ignore[index]
    pictures = kinds["figure"][0]  # type: ignore[index]
    taken = run["normalised_processor_seconds"]
    return {
        "request": taken["web"] / requests,
        "lesson": taken["graders"] / verdicts,
        "figure": taken["figures"] / pictures,
        "database": taken["database"] / verdicts,
        "nats": taken["NATS"] / verdicts,
    }


@dataclass(frozen=True)
class Fleet:
    """How many of each; `database`: the processors of PostgreSQL's machine."""

    web: int
    graders: int
    figures: int
    database: int = 6

    @property
    def servers(self) -> dict[str, int]:
        return {WEB: self.web, LOGIN: self.web, PUT: 1, GRADERS: self.graders, FIGURES: self.figures}


@dataclass(frozen=True)
class Moment:
    """What students do in it. `arriving`: how many log in, then open three pages, in its first `within` seconds. Each
    of those who work (`working`) sends `each_minute` submissions a minute, and asks for twice as many pages; at a
    deadline these rise to the end, `rising` times."""

    name: str
    seconds: float
    arriving: int
    within: float
    working: int
    each_minute: float
    rising: float = 1.0
    grading: str = "lesson"


def moments(students: int, share: float = 0.2) -> tuple[Moment, Moment]:
    """The fullest hour has this share of all in a lesson, who log in within five minutes and send something every five.
    In the last half-hour as many work, who send something every three minutes, twice as often in the end."""
    busy = round(students * share)
    lesson = Moment("les vingt premières minutes d’un cours", 1200.0, busy, 300.0, busy, 0.2)
    last = Moment("la dernière demi-heure avant 23 h 59", 1800.0, 0, 1.0, busy, 1 / 3, rising=2.0, grading="deadline")
    return lesson, last


WRONG = 2 / 3  # of submissions
#: Gradings in a student's day, besides those of the two moments' kind: a lesson of an hour, then homework.
DAILY = {"lesson": 12, "deadline": 6}
PAGES_A_SUBMISSION = 4.7  # requests of all kinds, as in the crowd


def arrivals(draw: np.random.Generator, count: int, seconds: float, rising: float) -> Times:
    """So many moments, sorted, of a density that goes up linearly by `rising` from the beginning to the end."""
    uniform = draw.random(count)
    if rising > 1.0:
        slope = rising - 1.0  # the distribution's inverse: (1 + slope t / 2) t / (1 + slope / 2) = u
        uniform = (np.sqrt(1.0 + 4.0 * uniform * (1.0 + slope / 2) * slope / 2) - 1.0) / slope
    return np.sort(uniform * seconds)


def load(moment: Moment, costs: Costs, draw: np.random.Generator) -> tuple[list[float], list[Route]]:
    """When each request or submission comes, and what it goes through."""
    mean = (1.0 + moment.rising) / 2
    sent = draw.poisson(moment.working * moment.each_minute * moment.seconds / 60.0 * mean)
    looked = draw.poisson(2 * sent)  # of pages that no submission asks for
    times = [
        arrivals(draw, sent, moment.seconds, moment.rising),
        arrivals(draw, looked, moment.seconds, moment.rising),
        draw.random(moment.arriving) * moment.within,
        draw.random(3 * moment.arriving) * moment.within,
    ]
    grading = costs.deadline if moment.grading == "deadline" else costs.lesson
    sigma = np.sqrt(np.log1p(costs.spread**2))
    gradings = draw.lognormal(np.log(grading) - sigma**2 / 2, sigma, sent)
    requests = draw.exponential(costs.request, (sent, 3))
    wrong = draw.random(sent) < WRONG
    routes: list[Route] = [
        (
            (WEB, web[0]),
            (PUT, costs.put),
            (GRADERS, seconds),
            (WEB, web[1] + web[2]),  # the event, then the verdict
            *(((FIGURES, costs.figure),) if bad else ()),
        )
        for web, seconds, bad in zip(requests.tolist(), gradings.tolist(), wrong.tolist(), strict=True)
    ]
    routes += [((WEB, seconds),) for seconds in draw.exponential(costs.request, looked).tolist()]
    routes += [((LOGIN, costs.login),)] * moment.arriving
    routes += [((WEB, seconds),) for seconds in draw.exponential(costs.request, 3 * moment.arriving).tolist()]
    when = np.concatenate(times)
    order = np.argsort(when, kind="stable")
    return when[order].tolist(), [routes[one] for one in order.tolist()]


def simulate(when: Sequence[float], routes: Sequence[Route], servers: Mapping[str, int]) -> list[dict[str, float]]:
    """Seconds that each has waited at each station that it has been through (twice: the sum). First come, first served.

    `when` is sorted.
    """
    free, queues = dict(servers), {name: deque[tuple[int, int, float]]() for name in servers}
    waited: list[dict[str, float]] = [{} for _ in routes]
    events: list[tuple[float, int, int]] = []  # the end of a service: when, of which job, at which of its stations
    now, coming = 0.0, 0

    def come(job: int, stage: int) -> None:
        station, seconds = routes[job][stage]
        if free[station]:
            free[station] -= 1
            waited[job].setdefault(station, 0.0)
            heapq.heappush(events, (now + seconds, job, stage))
        else:
            queues[station].append((job, stage, now))

    while coming < len(when) or events:
        if not events or (coming < len(when) and when[coming] <= events[0][0]):
            now = when[coming]
            come(coming, 0)
            coming += 1
            continue
        now, job, stage = heapq.heappop(events)
        station = routes[job][stage][0]
        if queues[station]:
            other, place, since = queues[station].popleft()
            waited[other][station] = waited[other].get(station, 0.0) + now - since
            heapq.heappush(events, (now + routes[other][place][1], other, place))
        else:
            free[station] += 1
        if stage + 1 < len(routes[job]):
            come(job, stage + 1)
    return waited


@dataclass(frozen=True)
class Found:
    """Of a moment: seconds from sending to the verdict's page, of pages, of log-ins; the share of each station that is
    used in its fullest minute, of what it can do."""

    verdicts: Times
    pages: Times
    logins: Times
    fullest: Mapping[str, float]


def lived(moment: Moment, costs: Costs, fleet: Fleet, seed: int = 1) -> Found:
    when, routes = load(moment, costs, np.random.default_rng(seed))
    waited = simulate(when, routes, fleet.servers)
    took: dict[str, list[float]] = {WEB: [], LOGIN: [], GRADERS: []}
    for route, waits in zip(routes, waited, strict=True):
        kind = GRADERS if len(route) > 1 else route[0][0]
        shown = sum(seconds for station, seconds in route if station != FIGURES)
        took[kind].append(shown + sum(wait for station, wait in waits.items() if station != FIGURES))
    verdicts, pages, logins = (np.array(took[kind]) for kind in (GRADERS, WEB, LOGIN))
    return Found(verdicts, pages, logins, _fullest(when, routes, costs, fleet))


def _fullest(when: Sequence[float], routes: Sequence[Route], costs: Costs, fleet: Fleet) -> dict[str, float]:
    """Besides the stations, what they all lean on: nobody queues for it here, and it is to have room."""
    servers = {**fleet.servers, DATABASE: fleet.database, NATS: 1}
    behind = ((DATABASE, costs.database), (NATS, costs.nats))
    asked = {station: np.zeros(int(when[-1] // 60) + 1) for station in servers}
    for moment, route in zip(when, routes, strict=True):
        for station, seconds in (*route, *(behind if len(route) > 1 else ())):
            asked[station][int(moment // 60)] += seconds
    return {station: float(sums.max()) / 60.0 / servers[station] for station, sums in asked.items()}


def processor_hours(students: int, costs: Costs) -> dict[str, float]:
    """Of a day, by part: what is used, not what is kept ready."""
    sent = {kind: students * count for kind, count in DAILY.items()}
    all_sent = sum(sent.values())
    seconds = {
        WEB: all_sent * PAGES_A_SUBMISSION * costs.request,
        GRADERS: sent["lesson"] * costs.lesson + sent["deadline"] * costs.deadline,
        FIGURES: all_sent * WRONG * costs.figure,
        DATABASE: all_sent * costs.database,
        NATS: all_sent * costs.nats,
    }
    return {part: taken / HOUR for part, taken in seconds.items()}


def row(name: str, found: Found) -> list[str]:
    shown = [1000.0 * float(one) for one in np.percentile(found.verdicts, [50, 95, 99])]
    first = max(found.fullest, key=lambda station: found.fullest[station])
    used = [f"{100 * found.fullest[station]:.0f} %" for station in (*STATIONS, DATABASE, NATS)]
    return [name, *map(figure, shown), figure(1000.0 * float(np.percentile(found.pages, 95))), *used, first]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--students", type=int, default=50_000)
    parser.add_argument("--share", type=float, default=0.2, help="of students who are at work in these moments")
    parser.add_argument("--graders", type=int, nargs="+", default=[25, 50, 100, 200])
    parser.add_argument("--web", type=int, default=12)
    parser.add_argument("--figures", type=int, default=12, help="one a web process")
    parser.add_argument("--deadline", type=float, help="seconds of a grading at the deadline")
    parser.add_argument("--price", type=float, default=price(), help="euros of a processor for an hour")
    parser.add_argument("--crowd", type=Path, help="a run to take figures from")
    asked = parser.parse_args()
    costs = Costs.read(crowd=asked.crowd)
    costs = costs if asked.deadline is None else replace(costs, deadline=asked.deadline)
    head = ["ms", "p50", "p95", "p99", "page p95", *STATIONS, DATABASE, NATS, "cède d’abord"]
    for moment in moments(asked.students, asked.share):
        rows = [
            row(f"{graders} correcteurs", lived(moment, costs, Fleet(asked.web, graders, asked.figures)))
            for graders in asked.graders
        ]
        print(f"{asked.students} élèves, {moment.name}\n\n{table(head, rows)}")
    hours = processor_hours(asked.students, costs)
    rows = [[part, figure(one), f"{one * asked.price:.2f}"] for part, one in hours.items()]
    rows.append(["en tout", figure(sum(hours.values())), f"{sum(hours.values()) * asked.price:.2f}"])
    print(table(["un jour", "heures de processeur", "euros"], rows))


if __name__ == "__main__":
    main()
