"""Queries of submissions and variants."""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any, NamedTuple
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, bindparam, func, insert, or_, select, update
from sqlalchemy.orm import Session, defer

from server.database import (
    detached_instance,
    prepared_statement,
    select_core,
    table_of,
    upsert_statement,
    utc_now,
    write_core,
)
from server.submissions.models import Submission, Variant


class GradingRow(NamedTuple):
    """The columns of a submission that grading needs."""

    id: UUID
    account_id: UUID
    exercise: str
    source: bytes
    seed: int
    created_at: datetime


_submissions = table_of(Submission)
INSERT = insert(_submissions)
#: On the hot path of a verdict: built once, without ORM objects.
GRADING_ROW = select(*(_submissions.c[name] for name in GradingRow._fields)).where(
    _submissions.c.id == bindparam("submission")
)


@prepared_statement
def _select_submission_by_id(submission_id: UUID) -> Select[Submission]:
    return select(Submission).where(Submission.id == submission_id)


def find_submission(db: Session, submission_id: UUID) -> Submission | None:
    return db.execute(*_select_submission_by_id(submission_id)).scalar_one_or_none()


def load_grading_row(db: Session, submission_id: UUID) -> GradingRow | None:
    row = select_core(db, GRADING_ROW, {"submission": submission_id}).one_or_none()
    return None if row is None else GradingRow(*row)


def insert_submission(db: Session, **values: Any) -> Submission:
    """Insert a submission that waits for its first grading; the returned object is detached."""
    write_core(db, INSERT, values)
    return detached_instance(Submission, {**values, "grading_id": None}.items())


def list_ungraded_submissions(db: Session) -> Sequence[Submission]:
    """Load all submissions that wait for their first grading, without their source."""
    query = select(Submission).where(Submission.grading_id.is_(None)).options(defer(Submission.source))
    return db.execute(query.order_by(Submission.created_at, Submission.id)).scalars().all()


@prepared_statement
def _select_waiting_counts(account_id: UUID, exercise: str, *, everywhere: bool) -> Select[str, int]:
    query = (
        select(Submission.exercise, func.count())
        .where(Submission.account_id == account_id, Submission.grading_id.is_(None))
        .group_by(Submission.exercise)
    )
    return query if everywhere else query.where(Submission.exercise == exercise)


def count_ungraded_by_exercise(db: Session, account_id: UUID, exercise: str | None = None) -> Mapping[str, int]:
    """Count an account's submissions that wait for their first grading, by exercise (in all, or in one alone)."""
    return dict(select_core(db, *_select_waiting_counts(account_id, exercise or "", everywhere=exercise is None)).all())


def count_ungraded_or_sent_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """Count an account's submissions that wait, or were sent since a time, by exercise."""
    return _count_sent_since_by_exercise(db, account_id, since, Submission.grading_id.is_(None))


def count_sent_since(db: Session, account_id: UUID, since: Mapping[str, datetime]) -> Mapping[str, int]:
    """Count an account's submissions sent since a time, by exercise."""
    return _count_sent_since_by_exercise(db, account_id, since)


def _count_sent_since_by_exercise(
    db: Session, account_id: UUID, since: Mapping[str, datetime], *alternatives: ColumnElement[bool]
) -> Mapping[str, int]:
    if not since:
        return {}
    conditions = [
        and_(Submission.exercise == name, or_(*alternatives, Submission.created_at >= when))
        for name, when in since.items()
    ]
    query = select(Submission.exercise, func.count()).where(Submission.account_id == account_id, or_(*conditions))
    return dict(db.execute(query.group_by(Submission.exercise)).all())


def find_latest_submission(db: Session, account_id: UUID, exercise: str) -> Submission | None:
    """Load an account's latest submission to an exercise, graded or not."""
    query = select(Submission).where(Submission.account_id == account_id, Submission.exercise == exercise)
    return db.execute(query.order_by(Submission.created_at.desc(), Submission.id.desc()).limit(1)).scalar_one_or_none()


def move_submissions(db: Session, old: UUID, new: UUID) -> None:
    db.execute(update(Submission).where(Submission.account_id == old).values(account_id=new))


def give_submissions_to(db: Session, submissions: Collection[UUID], new: UUID) -> None:
    db.execute(update(Submission).where(Submission.id.in_(submissions)).values(account_id=new))


@prepared_statement
def _select_seed(account_id: UUID, exercise: str) -> Select[int]:
    return select(Variant.seed).where(Variant.account_id == account_id, Variant.exercise == exercise)


def find_seed(db: Session, account_id: UUID, exercise: str) -> int | None:
    return select_core(db, *_select_seed(account_id, exercise)).scalar_one_or_none()


def load_existing_seed(db: Session, account_id: UUID, exercise: str) -> int:
    """Load a seed that exists."""
    seed: int = select_core(db, *_select_seed(account_id, exercise)).scalar_one()
    return seed


def insert_seed_once(db: Session, account_id: UUID, exercise: str, seed: int) -> None:
    """Insert a seed unless there is one: of two concurrent requests, the first one's stays."""
    row = {"account_id": account_id, "exercise": exercise, "seed": seed, "created_at": utc_now()}
    db.execute(upsert_statement(db, Variant).on_conflict_do_nothing(), row)


def move_variants(db: Session, old: UUID, new: UUID) -> None:
    """Move the variants of exercises for which `new` has none."""
    existing = select(Variant.exercise).where(Variant.account_id == new)
    moved = update(Variant).where(Variant.account_id == old, Variant.exercise.not_in(existing)).values(account_id=new)
    db.execute(moved.execution_options(synchronize_session=False))
