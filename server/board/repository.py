"""Queries on what the students of a class have sent: each answers for all of them at once.

The board is reckoned from their attempts (`gradebook.sent`), in Python: a statement for each of its figures would read
the same rows again and again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from typing import Any, NamedTuple
from uuid import UUID

from sqlalchemy import Row, Select, and_, bindparam, select
from sqlalchemy.orm import Session

from server.classes.models import Membership, Seat, Status
from server.database import NEVER, ask, table_of
from server.gradebook.models import Grading
from server.gradebook.sent import SUMS
from server.submissions.models import Submission

_submissions, _gradings, _members = table_of(Submission), table_of(Grading), table_of(Membership)
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


@cache
def _pulse() -> Select[*tuple[Any, ...]]:
    graded = and_(_sent.account_id == _members.c.account_id, _sent.revision.is_not(None))
    query = select(_members.c.account_id, *SUMS).select_from(_members.outerjoin(_submissions, graded))
    return query.where(IN_CLASS).group_by(_members.c.account_id).order_by(_members.c.account_id)


def pulse(db: Session, class_id: UUID) -> Sequence[object]:
    """What changes whenever an attempt of one of the class's students is graded, or somebody comes or goes."""
    return list(map(tuple, ask(db, _pulse(), {"class_id": class_id})))


@cache
def _sent_with() -> Select[UUID, bytes]:
    query = select(_sent.account_id, _sent.source).select_from(ATTEMPTS)
    query = query.where(SENT, _sent.exercise == bindparam("exercise"), _found.diagnosis == bindparam("diagnosis"))
    return query.order_by(_sent.created_at.desc(), _sent.id.desc()).limit(bindparam("most"))


def sent_with(db: Session, scope: Scope, exercise: str, diagnosis: str, most: int) -> Sequence[Row[UUID, bytes]]:
    """Student and source of the latest attempts that had this misconception."""
    return ask(db, _sent_with(), scope(exercise=exercise, diagnosis=diagnosis, most=most)).all()
