"""What the database says at the end, against what the students were told."""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from sqlalchemy import Select, func, select

from server.database import Database
from server.gradebook import service as gradebook
from server.gradebook.models import Grading, Standing
from server.queue.models import Job
from server.submissions.models import Submission
from tests.benchmarks.chaos.students import Attempt, Ledger

DRAIN_SECONDS = 180.0
SUBMISSIONS = select(Submission.id, Submission.source, Grading.outcome, Grading.score).outerjoin(
    Grading, Grading.id == Submission.grading_id
)
HISTORY = select(Grading.submission_id, func.count()).group_by(Grading.submission_id)
STANDINGS = select(Standing.account_id, Standing.attempts, Standing.best_score)
JOBS = select(Job.key, Job.tries, Job.lease_owner, Job.lease_until)


def rows(database: Database, query: Select[Any]) -> Sequence[Any]:
    with database.read() as db:
        return db.execute(query).all()


def drained(database: Database) -> float:
    """Waits until no job is left; how long it took. Raises TimeoutError."""
    begun = time.monotonic()
    while left := rows(database, JOBS):
        if time.monotonic() - begun > DRAIN_SECONDS:
            raise TimeoutError(f"jobs are stuck: {left}")
        time.sleep(0.1)
    return time.monotonic() - begun


def broken(database: Database, ledger: Ledger, *, may_give_up: bool) -> Iterator[str]:
    """Each promise that was not kept, in a sentence. `may_give_up`: as often as workers die, jobs may be given up."""
    kept = {str(row.id): row for row in rows(database, SUBMISSIONS)}
    history = {str(one): count for one, count in rows(database, HISTORY)}
    for attempt in ledger.attempts:
        yield from _of_attempt(attempt, kept.get(attempt.id), history.get(attempt.id, 0), may_give_up=may_give_up)
    for number, count in Counter(_number(row.source) for row in kept.values()).items():
        if count > 1:
            yield f"attempt {number} was stored {count} times"
    unknown = kept.keys() - {attempt.id for attempt in ledger.attempts}
    if unknown:
        yield f"{len(unknown)} submissions of which no student was told"
    yield from _standings(database, ledger)


def _number(source: bytes) -> int:
    found = re.match(rb"# envoi (\d+)\n", bytes(source))
    assert found
    return int(found[1])


def _of_attempt(attempt: Attempt, row: Any, gradings: int, *, may_give_up: bool) -> Iterator[str]:
    name = f"attempt {attempt.number} ({attempt.id or 'never accepted'})"
    if not attempt.id or not attempt.outcome:
        yield f"{name}: its student has given up after {attempt.tries} tries"
        return
    if row is None:
        yield f"{name}: lost"
        return
    if gradings != 1:
        yield f"{name}: graded {gradings} times"
    if (row.outcome, row.score) != (attempt.outcome, attempt.score if row.outcome != "internal_error" else None):
        yield f"{name}: {row.outcome} {row.score} is kept, {attempt.outcome} {attempt.score} was told"
    if row.outcome != attempt.expected and not (may_give_up and row.outcome == "internal_error"):
        yield f"{name}: {row.outcome} instead of {attempt.expected}"


def _standings(database: Database, ledger: Ledger) -> Iterator[str]:
    """By our own sum, then by the service's."""
    counted = [one for one in ledger.attempts if one.outcome and one.outcome != "internal_error"]
    attempts = Counter(one.account for one in counted)
    for account, count, best in rows(database, STANDINGS):
        mine = max(one.score or 0.0 for one in counted if one.account == str(account))
        if (count, best) != (attempts.pop(str(account)), mine):
            yield f"account {account}: {count} attempts, best {best}"
    if attempts:
        yield f"accounts without a standing: {attempts}"
    _, changed = gradebook.rebuild_all_standings(database)
    if changed:
        yield f"{changed} standings differ from the history"
