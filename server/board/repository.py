"""Queries on what the students of a class have sent: each answers for all of them at once.

The board is reckoned from one reading of their attempts, in Python: a statement for each of its figures would read the
same rows again and again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from typing import Any, NamedTuple
from uuid import UUID

from sqlalchemy import Row, Select, and_, bindparam, func, select
from sqlalchemy.orm import Session

from server.classes.models import Membership, Seat, Status
from server.database import NEVER, Telling, Told, ask, table_of
from server.gradebook.models import Grading, Standing
from server.submissions.models import Submission

_submissions, _gradings, _members = table_of(Submission), table_of(Grading), table_of(Membership)
_standings = table_of(Standing)
_sent, _found = _submissions.c, _gradings.c
IN_CLASS = and_(
    _members.c.class_id == bindparam("class_id"),
    _members.c.role == Seat.student,
    _members.c.status == Status.active,
)
#: Graded attempts of the students who are in the class, at the exercises that count, but errors of ours.
SENT = and_(
    IN_CLASS,
    _sent.exercise.in_(bindparam("exercises", expanding=True)),
    _sent.created_at <= bindparam("until"),
    _found.score.is_not(None),
)
ATTEMPTS = _submissions.join(_gradings, _found.id == _sent.grading_id).join(
    _members, _members.c.account_id == _sent.account_id
)


@dataclass(frozen=True)
class Scope:
    """Of which class, in which exercises, sent until when (None: until now)."""

    class_id: UUID
    exercises: Sequence[str]
    until: datetime | None

    def __call__(self, **more: object) -> dict[str, object]:
        """As the parameters of a statement."""
        return {"class_id": self.class_id, "exercises": self.exercises, "until": self.until or NEVER, **more}


class Sent(NamedTuple):
    """An attempt that counts, as it is graded now."""

    account: UUID
    exercise: str
    sent_at: datetime
    digest: str
    outcome: str
    score: float
    diagnosis: str | None
    submission: UUID


TOLD = Telling(
    _sent.account_id,
    _sent.exercise,
    _sent.created_at,
    _sent.digest,
    _found.outcome,
    _found.score,
    _found.diagnosis,
    _sent.id,
)


@cache
def _history() -> Select[*tuple[Any, ...]]:
    query = select(*TOLD.asked).select_from(ATTEMPTS).where(SENT)
    return query.order_by(_sent.account_id, _sent.exercise, _sent.created_at, _sent.id)


def history(db: Session, scope: Scope) -> Sequence[Told]:
    """Every attempt that counts: by student, then by exercise, in the order in which they were sent."""
    return list(map(tuple, ask(db, _history(), scope()).all()))


@cache
def _pulse() -> Select[Any, Any, Any, Any]:
    members = _members.outerjoin(_standings, _standings.c.account_id == _members.c.account_id)
    columns = (
        func.count(_members.c.account_id.distinct()),
        func.sum(_standings.c.attempts),
        func.max(_standings.c.last_at),
        func.sum(_standings.c.best_score),
    )
    return select(*columns).select_from(members).where(IN_CLASS)


def pulse(db: Session, class_id: UUID) -> tuple[object, ...]:
    """What changes whenever an attempt of one of the class's students is graded, or somebody comes or goes."""
    return tuple(db.execute(_pulse(), {"class_id": class_id}).one())


@cache
def _sent_with() -> Select[UUID, bytes]:
    query = select(_sent.account_id, _sent.source).select_from(ATTEMPTS)
    query = query.where(SENT, _sent.exercise == bindparam("exercise"), _found.diagnosis == bindparam("diagnosis"))
    return query.order_by(_sent.created_at.desc(), _sent.id.desc()).limit(bindparam("most"))


def sent_with(db: Session, scope: Scope, exercise: str, diagnosis: str, most: int) -> Sequence[Row[UUID, bytes]]:
    """Student and source of the latest attempts that had this misconception."""
    return ask(db, _sent_with(), scope(exercise=exercise, diagnosis=diagnosis, most=most)).all()
