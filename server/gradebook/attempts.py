"""Load a submission with the grading that counts, and whether its author's assignments may withhold anything."""

from __future__ import annotations

from typing import Any, NamedTuple
from uuid import UUID

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from server.assignments.feedback_repository import has_holds_clause
from server.database import table_of, utc_now
from server.gradebook.models import Grading
from server.submissions.models import Submission


class StoredAttempt(NamedTuple):
    """`may_be_held`: some assignment of the author asks for the exercise, so that its feedback may be withheld."""

    submission: Submission
    grading: Grading | None
    may_be_held: bool


def load_stored_attempt(db: Session, submission_id: UUID) -> StoredAttempt | None:
    """Load an attempt as it stands now."""
    return _load_attempt_of_query(db, _select_attempts().where(Submission.id == submission_id))


def load_latest_stored_attempt(db: Session, account_id: UUID, exercise: str) -> StoredAttempt | None:
    """Load the attempt that an account sent last to an exercise."""
    query = _select_attempts().where(Submission.account_id == account_id, Submission.exercise == exercise)
    return _load_attempt_of_query(db, query.order_by(Submission.created_at.desc(), Submission.id.desc()).limit(1))


def _select_attempts() -> Select[*tuple[Any, ...]]:
    query = select(Submission, Grading, has_holds_clause(table_of(Submission)))
    return query.outerjoin(Grading, Grading.id == Submission.grading_id)


def _load_attempt_of_query(db: Session, query: Select[*tuple[Any, ...]]) -> StoredAttempt | None:
    row = db.execute(query.execution_options(populate_existing=True), {"now": utc_now()}).one_or_none()
    return None if row is None else StoredAttempt(*row)
