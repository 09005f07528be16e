"""Queries on submissions and deals."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any, NamedTuple
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, bindparam, func, insert, or_, select, update
from sqlalchemy.orm import Session, defer

from server.database import ask, change, loaded, prepared, table_of, upsert_statement, utc_now
from server.submissions.models import Submission, Variant


class GradingRow(NamedTuple):
    """What grading asks of a submission."""

    id: UUID
    account_id: UUID
    exercise: str
    source: bytes
    seed: int
    created_at: datetime


_submissions = table_of(Submission)
ADD = insert(_submissions)
#: On the way to a verdict: made once, and for no object.
SENT = select(*(_submissions.c[name] for name in GradingRow._fields)).where(
    _submissions.c.id == bindparam("submission")
)


@prepared
def _by_id(submission_id: UUID) -> Select[Submission]:
    return select(Submission).where(Submission.id == submission_id)


def by_id(db: Session, submission_id: UUID) -> Submission | None:
    return db.execute(*_by_id(submission_id)).scalar_one_or_none()


def load_grading_row(db: Session, submission_id: UUID) -> GradingRow | None:
    row = ask(db, SENT, {"submission": submission_id}).one_or_none()
    return None if row is None else GradingRow(*row)


def add(db: Session, **values: Any) -> Submission:
    """Stores a submission that waits for its first grading. What is given back is not the session's."""
    change(db, ADD, values)
    return loaded(Submission, {**values, "grading_id": None}.items())


def ungraded(db: Session) -> Sequence[Submission]:
    """All that waits for its first grading, as it was sent."""
    query = select(Submission).where(Submission.grading_id.is_(None)).options(defer(Submission.source))
    return db.execute(query.order_by(Submission.created_at, Submission.id)).scalars().all()


@prepared
def _waiting(account_id: UUID, exercise: str, *, everywhere: bool) -> Select[str, int]:
    query = (
        select(Submission.exercise, func.count())
        .where(Submission.account_id == account_id, Submission.grading_id.is_(None))
        .group_by(Submission.exercise)
    )
    return query if everywhere else query.where(Submission.exercise == exercise)


def waiting(db: Session, account_id: UUID, exercise: str | None = None) -> Mapping[str, int]:
    """How many of an account's submissions wait for their first grading, by exercise (in all, or in one alone)."""
    return dict(ask(db, *_waiting(account_id, exercise or "", everywhere=exercise is None)).all())


def waiting_or_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """How many of an account's submissions wait, or were sent from these times on, by exercise, in these alone."""
    return _counted(db, account_id, since, Submission.grading_id.is_(None))


def sent_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """How many of an account's submissions were sent from these times on, by exercise, in these alone."""
    return _counted(db, account_id, since)


def _counted(
    db: Session, account_id: UUID, since: Mapping[str, datetime], *besides: ColumnElement[bool]
) -> Mapping[str, int]:
    if not since:
        return {}
    either = [
        and_(Submission.exercise == name, or_(*besides, Submission.created_at >= when)) for name, when in since.items()
    ]
    query = select(Submission.exercise, func.count()).where(Submission.account_id == account_id, or_(*either))
    return dict(db.execute(query.group_by(Submission.exercise)).all())


def latest(db: Session, account_id: UUID, exercise: str) -> Submission | None:
    """What was sent last, graded or not."""
    query = select(Submission).where(Submission.account_id == account_id, Submission.exercise == exercise)
    return db.execute(query.order_by(Submission.created_at.desc(), Submission.id.desc()).limit(1)).scalar_one_or_none()


def move_submissions(db: Session, old: UUID, new: UUID) -> None:
    db.execute(update(Submission).where(Submission.account_id == old).values(account_id=new))


@prepared
def _seed(account_id: UUID, exercise: str) -> Select[int]:
    return select(Variant.seed).where(Variant.account_id == account_id, Variant.exercise == exercise)


def find_seed(db: Session, account_id: UUID, exercise: str) -> int | None:
    return ask(db, *_seed(account_id, exercise)).scalar_one_or_none()


def load_seed(db: Session, account_id: UUID, exercise: str) -> int:
    """The seed that is known to be kept."""
    found: int = ask(db, *_seed(account_id, exercise)).scalar_one()
    return found


def insert_seed(db: Session, account_id: UUID, exercise: str, seed: int) -> None:
    """Keeps a seed, unless there is one already: of two requests at once, the first one's stays."""
    row = {"account_id": account_id, "exercise": exercise, "seed": seed, "created_at": utc_now()}
    db.execute(upsert_statement(db, Variant).on_conflict_do_nothing(), row)


def move_variants(db: Session, old: UUID, new: UUID) -> None:
    """Moves the deals of exercises for which `new` has none."""
    already_dealt = select(Variant.exercise).where(Variant.account_id == new)
    moved = (
        update(Variant).where(Variant.account_id == old, Variant.exercise.not_in(already_dealt)).values(account_id=new)
    )
    db.execute(moved.execution_options(synchronize_session=False))
