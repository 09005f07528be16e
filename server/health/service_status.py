"""Current state of the service for `balise top`: counts, times and technical names, no personal data."""

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
from server.base.version import VERSION
from server.database import utc_now
from server.health import repository
from server.queue import lease_owner
from server.submissions.service import GRADE

RATE_WINDOW = timedelta(minutes=5)
TIMES_WINDOW = timedelta(minutes=15)
ERRORS_WINDOW = timedelta(hours=1)
MAX_WORKERS, MAX_ERRORS, MAX_VERDICTS = 64, 8, 2_000
UNKNOWN_OWNER = "?|?|?|0|"
UNGRADED = "correction échouée de notre côté"


@dataclass(frozen=True)
class QueueDepth:
    """Jobs of a kind: how many wait, the age of the oldest in seconds, how many run."""

    kind: str
    waiting: int
    oldest: float
    running: int


@dataclass(frozen=True)
class BusyWorker:
    """A worker (`host`, `pid`) and the job that it has run for `seconds`; `exercise` for submissions."""

    host: str
    pid: int
    kind: str
    exercise: str
    seconds: float
    tries: int


@dataclass(frozen=True)
class VerdictTimes:
    """Verdicts a minute over RATE_WINDOW; seconds from sending to first verdict over TIMES_WINDOW, if any."""

    per_minute: float
    p50: float | None
    p95: float | None


@dataclass(frozen=True)
class RecentError:
    """An error of ours: when, where, and its message."""

    at: datetime
    where: str
    message: str


@dataclass(frozen=True)
class WebProcessStatus:
    """State of one web process: recent visitors, requests a minute, watchers, workers, walls, readiness."""

    visitors: int
    requests_per_minute: float
    following: int
    workers: int
    wanted: int
    walls: Mapping[str, bool]
    checks: Mapping[str, str]


@dataclass(frozen=True)
class ServiceStatus:
    """`process` is None where only the database was read; `version` is that of the program that read."""

    at: datetime
    queue: Sequence[QueueDepth]
    workers: Sequence[BusyWorker]
    verdicts: VerdictTimes
    faults: Sequence[RecentError]
    process: WebProcessStatus | None = None
    version: str = VERSION


def load_service_status(
    db: Session, process: WebProcessStatus | None = None, faults: Sequence[RecentError] = ()
) -> ServiceStatus:
    """Load the state; a web process adds its own."""
    now = utc_now()
    errors = [*faults, *_load_recent_internal_errors(db, now)]
    return ServiceStatus(
        at=now,
        queue=_load_queue_depths(db, now),
        workers=_load_busy_workers(db, now),
        verdicts=_load_verdict_times(db, now),
        faults=sorted(errors, key=lambda fault: fault.at, reverse=True)[:MAX_ERRORS],
        process=process,
    )


def _load_queue_depths(db: Session, now: datetime) -> list[QueueDepth]:
    counts: dict[str, dict[bool, tuple[int, datetime]]] = {}
    for kind, running, count, since in repository.load_queue_depths(db):
        counts.setdefault(kind, {})[running] = (count, since)
    nothing = (0, now)
    return [
        QueueDepth(
            kind,
            by_state.get(False, nothing)[0],
            _seconds_since(by_state.get(False, nothing)[1], now),
            by_state.get(True, nothing)[0],
        )
        for kind, by_state in sorted(counts.items())
    ]


def _seconds_since(when: datetime, now: datetime) -> float:
    return max(0.0, (now - when).total_seconds())


def _load_busy_workers(db: Session, now: datetime) -> list[BusyWorker]:
    jobs = repository.load_running_jobs(db, MAX_WORKERS)
    keys = {key: UUID(key) for _, kind, key, _, _ in jobs if kind == GRADE}
    exercises = repository.load_exercises_by_submission(db, keys.values()) if keys else {}
    busy = []
    for owner_name, kind, key, started_at, tries in jobs:
        owner = lease_owner.parse_owner(owner_name or UNKNOWN_OWNER)
        exercise = exercises.get(keys[key], "") if key in keys else ""
        busy.append(BusyWorker(owner.host, owner.pid, kind, exercise, _seconds_since(started_at or now, now), tries))
    return sorted(busy, key=lambda worker: (worker.host, worker.pid))


def _load_verdict_times(db: Session, now: datetime) -> VerdictTimes:
    recent = repository.count_gradings_since(db, now - RATE_WINDOW)
    verdicts = repository.load_first_gradings_since(db, now - TIMES_WINDOW, MAX_VERDICTS)
    seconds = [(finished_at - sent_at).total_seconds() for _, _, _, sent_at, _, finished_at in verdicts]
    cuts = quantiles(seconds, n=20, method="inclusive") if len(seconds) > 1 else seconds * 19
    p50, p95 = (cuts[9], cuts[18]) if cuts else (None, None)
    return VerdictTimes(recent * 60 / RATE_WINDOW.total_seconds(), p50, p95)


def _load_recent_internal_errors(db: Session, now: datetime) -> list[RecentError]:
    rows = repository.load_latest_gradings_with_outcome(db, Outcome.INTERNAL_ERROR, now - ERRORS_WINDOW, MAX_ERRORS)
    return [RecentError(at, exercise, UNGRADED) for at, exercise in rows]


def service_status_to_json(overview: ServiceStatus) -> dict[str, Any]:
    """Convert to JSON, with times in ISO 8601."""
    content: dict[str, Any] = json.loads(json.dumps(asdict(overview), default=datetime.isoformat))
    return content
