"""Queries on one student's work, as who teaches them reads it: all of it, or what was sent until a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, func, select
from sqlalchemy.orm import Session

from server.database import NEVER, ask, prepared
from server.gradebook.models import Grading
from server.submissions.models import Submission

#: Of a verdict, without reading the whole of it.
MISTAKE = Grading.verdict["diagnosis"]["title"].as_string()


@dataclass(frozen=True)
class AttemptSummary:
    """An attempt in a list: `mistake` is the title of its `diagnosis`, or empty; no outcome while it waits."""

    id: UUID
    number: int
    sent_at: datetime
    outcome: str | None
    score: float | None
    mistake: str
    diagnosis: str | None


@dataclass(frozen=True)
class ExerciseWork:
    """What somebody's attempts at an exercise come to; `best` in [0, 1], None while nothing is graded."""

    attempts: int
    best: float | None
    last_at: datetime
    mistake: str


@prepared
def _attempts(
    account_id: UUID, exercise: str, until: datetime, skipped: int, *, most: int
) -> Select[int, UUID, datetime, str | None, float | None, str | None, str | None]:
    there = _sent(account_id, exercise, until)
    total = select(func.count()).select_from(Submission).where(there).scalar_subquery()
    query = (
        select(total, Submission.id, Submission.created_at, Grading.outcome, Grading.score, MISTAKE, Grading.diagnosis)
        .outerjoin(Grading, Grading.id == Submission.grading_id)
        .where(there)
        .order_by(Submission.created_at.desc(), Submission.id.desc())
    )
    return query.limit(most).offset(skipped)


def list_attempts(
    db: Session, account_id: UUID, exercise: str, until: datetime | None, *, most: int, skipped: int = 0
) -> tuple[Sequence[AttemptSummary], int]:
    """Some attempts, newest first, and how many there are in all."""
    rows = ask(db, *_attempts(account_id, exercise, until or NEVER, skipped, most=most)).all()
    tried = [
        AttemptSummary(name, count - place, sent_at, outcome, score, mistake or "", diagnosis)
        for place, (count, name, sent_at, outcome, score, mistake, diagnosis) in enumerate(rows, skipped)
    ]
    return tried, rows[0][0] if rows else 0


@prepared
def _in_order(account_id: UUID, exercise: str, until: datetime, skipped: int, most: int) -> Select[Submission]:
    query = select(Submission).where(_sent(account_id, exercise, until))
    return query.order_by(Submission.created_at, Submission.id).limit(most).offset(skipped)


def load_with_previous(
    db: Session, account_id: UUID, exercise: str, until: datetime | None, number: int
) -> Sequence[Submission]:
    """The attempt of that number (from 1) after the one before it; it alone where it is the first; none beyond."""
    first = max(0, number - 2)
    query = _in_order(account_id, exercise, until or NEVER, first, number - first)
    found = db.execute(*query).scalars().all()
    return found if len(found) == number - first else []


def load_by_exercise(db: Session, account_id: UUID, module: str, until: datetime | None) -> Mapping[str, ExerciseWork]:
    """What somebody's attempts come to, for each exercise of a module that they have tried."""
    mistakes = {row[0]: row[1] for row in ask(db, *_last_mistakes(account_id, until or NEVER))}
    return {
        exercise: ExerciseWork(count, best, last_at, mistakes.get(exercise) or "")
        for exercise, count, best, last_at in ask(db, *_sums(account_id, until or NEVER))
        if exercise.startswith(f"{module}/")
    }


@prepared
def _sums(account_id: UUID, until: datetime) -> Select[str, int, float | None, datetime]:
    query = select(
        Submission.exercise, func.count(Submission.id), func.max(Grading.score), func.max(Submission.created_at)
    ).outerjoin(Grading, Grading.id == Submission.grading_id)
    query = query.where(Submission.account_id == account_id, Submission.created_at <= until)
    return query.group_by(Submission.exercise)


@prepared
def _last_mistakes(account_id: UUID, until: datetime) -> Select[str, str | None]:
    """Of the latest attempt at each exercise that was graded without an error of ours."""
    turn = func.row_number().over(
        partition_by=Submission.exercise, order_by=(Submission.created_at.desc(), Submission.id.desc())
    )
    numbered = (
        select(Submission.exercise, Submission.grading_id, turn.label("turn"))
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id == account_id, Submission.created_at <= until, Grading.score.is_not(None))
        .subquery()
    )
    latest = select(numbered.c.exercise, MISTAKE).join(Grading, Grading.id == numbered.c.grading_id)
    return latest.where(numbered.c.turn == 1)


def _sent(account_id: UUID, exercise: str, until: datetime) -> ColumnElement[bool]:
    return and_(Submission.account_id == account_id, Submission.exercise == exercise, Submission.created_at <= until)
