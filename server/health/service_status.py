"""What the service does now, for who looks at it in a terminal: counts, times and names of ours, of nobody's work."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, timedelta
from statistics import quantiles
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.database import utc_now
from server.health import repository
from server.queue import lease_owner
from server.submissions.service import GRADE

RATE_OVER = timedelta(minutes=5)
TIMES_OVER = timedelta(minutes=15)
ERRORS_OVER = timedelta(hours=1)
MOST_WORKERS, MOST_FAULTS, MOST_VERDICTS = 64, 8, 2_000
NOBODY = "?|?|?|0|"
UNGRADED = "correction échouée de notre côté"


@dataclass(frozen=True)
class QueueDepth:
    """The jobs of a kind: how many wait, for how many seconds the oldest does, how many are being done."""

    kind: str
    waiting: int
    oldest: float
    running: int


@dataclass(frozen=True)
class BusyWorker:
    """A worker (`host`, `pid`) and what it has done for so many `seconds`; `exercise` of a submission."""

    host: str
    pid: int
    kind: str
    exercise: str
    seconds: float
    tries: int


@dataclass(frozen=True)
class VerdictTimes:
    """A minute, over RATE_OVER; then the seconds from sending to first verdict, over TIMES_OVER: None where there is
    none."""

    per_minute: float
    p50: float | None
    p95: float | None


@dataclass(frozen=True)
class RecentError:
    """An error of ours: when, in what, and what was told of it."""

    at: datetime
    where: str
    message: str


@dataclass(frozen=True)
class WebProcessStatus:
    """What a web process knows of itself: `visitors` of the last minutes, requests a minute, pages that follow
    something, its own workers, the walls as probed, and what readiness says."""

    visitors: int
    requests_per_minute: float
    following: int
    workers: int
    wanted: int
    walls: Mapping[str, bool]
    checks: Mapping[str, str]


@dataclass(frozen=True)
class ServiceStatus:
    """`process` is None where only the database was read."""

    at: datetime
    queue: Sequence[QueueDepth]
    workers: Sequence[BusyWorker]
    verdicts: VerdictTimes
    faults: Sequence[RecentError]
    process: WebProcessStatus | None = None


def load_status(
    db: Session, process: WebProcessStatus | None = None, faults: Sequence[RecentError] = ()
) -> ServiceStatus:
    """With what a web process adds of its own."""
    now = utc_now()
    every = [*faults, *_failed(db, now)]
    return ServiceStatus(
        at=now,
        queue=_queue(db, now),
        workers=_workers(db, now),
        verdicts=_verdicts(db, now),
        faults=sorted(every, key=lambda fault: fault.at, reverse=True)[:MOST_FAULTS],
        process=process,
    )


def _queue(db: Session, now: datetime) -> list[QueueDepth]:
    found: dict[str, dict[bool, tuple[int, datetime]]] = {}
    for kind, begun, count, since in repository.queue_depths(db):
        found.setdefault(kind, {})[begun] = (count, since)
    nothing = (0, now)
    return [
        QueueDepth(kind, of.get(False, nothing)[0], _since(of.get(False, nothing)[1], now), of.get(True, nothing)[0])
        for kind, of in sorted(found.items())
    ]


def _since(when: datetime, now: datetime) -> float:
    return max(0.0, (now - when).total_seconds())


def _workers(db: Session, now: datetime) -> list[BusyWorker]:
    jobs = repository.leased_jobs(db, MOST_WORKERS)
    keys = {key: UUID(key) for _, kind, key, _, _ in jobs if kind == GRADE}
    exercises = repository.exercises_by_submission(db, keys.values()) if keys else {}
    busy = []
    for name, kind, key, started_at, tries in jobs:
        who = lease_owner.parse_owner(name or NOBODY)
        exercise = exercises.get(keys[key], "") if key in keys else ""
        busy.append(BusyWorker(who.host, who.pid, kind, exercise, _since(started_at or now, now), tries))
    return sorted(busy, key=lambda one: (one.host, one.pid))


def _verdicts(db: Session, now: datetime) -> VerdictTimes:
    recent = repository.count_graded_since(db, now - RATE_OVER)
    found = repository.first_verdicts(db, now - TIMES_OVER, MOST_VERDICTS)
    taken = [(finished_at - sent_at).total_seconds() for _, _, _, sent_at, _, finished_at in found]
    cuts = quantiles(taken, n=20, method="inclusive") if len(taken) > 1 else taken * 19
    p50, p95 = (cuts[9], cuts[18]) if cuts else (None, None)
    return VerdictTimes(recent * 60 / RATE_OVER.total_seconds(), p50, p95)


def _failed(db: Session, now: datetime) -> list[RecentError]:
    rows = repository.latest_failures(db, Outcome.INTERNAL_ERROR, now - ERRORS_OVER, MOST_FAULTS)
    return [RecentError(at, exercise, UNGRADED) for at, exercise in rows]


def to_json(overview: ServiceStatus) -> dict[str, Any]:
    """Times in ISO 8601."""
    made: dict[str, Any] = json.loads(json.dumps(asdict(overview), default=datetime.isoformat))
    return made
