"""Queries on one student's work, as a teacher reads it: all of it, or what was sent until a time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, and_, func, select
from sqlalchemy.orm import Session

from server.database import END_OF_TIME
from server.gradebook.models import Grading
from server.submissions.models import Submission

#: Read out of the JSON, without loading the whole verdict.
MISCONCEPTION_TITLE = Grading.verdict["diagnosis"]["title"].as_string()


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
    """A student's attempts at an exercise, summed up; `best` in [0, 1], None while nothing is graded."""

    attempts: int
    best: float | None
    last_at: datetime
    mistake: str


def list_attempt_summaries(
    db: Session, account_id: UUID, exercise: str, until: datetime | None, *, limit: int, offset: int = 0
) -> tuple[Sequence[AttemptSummary], int]:
    """Return some attempts, newest first, and how many there are in all."""
    sent = _is_sent_attempt(account_id, exercise, until)
    total = select(func.count()).select_from(Submission).where(sent).scalar_subquery()
    columns = (Submission.id, Submission.created_at, Grading.outcome, Grading.score, MISCONCEPTION_TITLE)
    query = (
        select(total, *columns, Grading.diagnosis)
        .outerjoin(Grading, Grading.id == Submission.grading_id)
        .where(sent)
        .order_by(Submission.created_at.desc(), Submission.id.desc())
    )
    rows = db.execute(query.limit(limit).offset(offset)).all()
    attempts = [
        AttemptSummary(id, count - index, sent_at, outcome, score, mistake or "", diagnosis)
        for index, (count, id, sent_at, outcome, score, mistake, diagnosis) in enumerate(rows, offset)
    ]
    return attempts, rows[0][0] if rows else 0


def load_attempt_and_previous(
    db: Session, account_id: UUID, exercise: str, until: datetime | None, number: int
) -> Sequence[Submission]:
    """Return the attempt of that number (from 1) after the one before it; the first one alone; nothing beyond."""
    offset = max(0, number - 2)
    query = select(Submission).where(_is_sent_attempt(account_id, exercise, until))
    query = query.order_by(Submission.created_at, Submission.id).limit(number - offset).offset(offset)
    submissions = db.execute(query).scalars().all()
    return submissions if len(submissions) == number - offset else []


def load_work_by_exercise(
    db: Session, account_id: UUID, module: str, until: datetime | None
) -> Mapping[str, ExerciseWork]:
    """Return a student's work at each exercise of a module that they have tried."""
    query = select(
        Submission.exercise, func.count(Submission.id), func.max(Grading.score), func.max(Submission.created_at)
    ).outerjoin(Grading, Grading.id == Submission.grading_id)
    query = query.where(Submission.account_id == account_id, Submission.created_at <= (until or END_OF_TIME))
    mistakes = _load_latest_mistake_titles(db, account_id, until or END_OF_TIME)
    return {
        exercise: ExerciseWork(count, best, last_at, mistakes.get(exercise) or "")
        for exercise, count, best, last_at in db.execute(query.group_by(Submission.exercise))
        if exercise.startswith(f"{module}/")
    }


def _load_latest_mistake_titles(db: Session, account_id: UUID, until: datetime) -> Mapping[str, str | None]:
    """Return the title of the misconception of the latest attempt at each exercise, internal errors left out."""
    rank = func.row_number().over(
        partition_by=Submission.exercise, order_by=(Submission.created_at.desc(), Submission.id.desc())
    )
    ranked = (
        select(Submission.exercise, Submission.grading_id, rank.label("rank"))
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id == account_id, Submission.created_at <= until, Grading.score.is_not(None))
        .subquery()
    )
    query = select(ranked.c.exercise, MISCONCEPTION_TITLE).join(Grading, Grading.id == ranked.c.grading_id)
    return {row[0]: row[1] for row in db.execute(query.where(ranked.c.rank == 1))}


def _is_sent_attempt(account_id: UUID, exercise: str, until: datetime | None) -> ColumnElement[bool]:
    return and_(
        Submission.account_id == account_id,
        Submission.exercise == exercise,
        Submission.created_at <= (until or END_OF_TIME),
    )
