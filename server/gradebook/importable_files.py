"""The files of a student that later programs may import: in each exercise, the last one with full marks."""

from collections.abc import Collection, Mapping
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, func, or_, select
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.assignments import feedback, sittings
from server.course.models import Course
from server.course.reuse import NOTHING_OWN, Own
from server.database import utc_now
from server.gradebook.models import Grading
from server.sandbox.values import LIBRARY_MENTION
from server.submissions.models import Submission
from server.submissions.repository import GradingRow


def load_importable_files(db: Session, course: Course, submission: Submission | GradingRow) -> Own:
    """Load the files that an attempt may import, as of when it was sent; none where it does not mention any."""
    return _load_importable_files_at(
        db, course, submission.account_id, submission.exercise, submission.source, submission.created_at
    )


def load_importable_files_now(db: Session, course: Course, account_id: UUID, exercise: str, source: bytes) -> Own:
    """Load the files that a program may import now, which has not been sent."""
    return _load_importable_files_at(db, course, account_id, exercise, source, utc_now())


def _load_importable_files_at(
    db: Session, course: Course, account_id: UUID, exercise: str, source: bytes, sent_at: datetime
) -> Own:
    reused = [earlier.id for earlier in course.importable_exercises(exercise)]
    if not reused or LIBRARY_MENTION not in source:
        return NOTHING_OWN
    submissions = _select_importable(db, account_id, reused, sent_at)
    rows = db.execute(select(Submission.exercise, Submission.source).where(Submission.id.in_(submissions)))
    return {row.exercise: row.source for row in rows}


def load_exercises_in_sat_tests(db: Session, course: Course, submission: Submission | GradingRow) -> frozenset[str]:
    """Load the exercises of the tests that the author sat when they sent an attempt, if it may import anything."""
    if not course.importable_exercises(submission.exercise):
        return frozenset()
    return sittings.load_exercises_in_sat_tests(db, submission.account_id, submission.created_at)


def load_importable_file_times(db: Session, account_id: UUID, exercises: Collection[str]) -> Mapping[str, datetime]:
    """Return when the files were sent that a program may import now, by exercise."""
    if not exercises:
        return {}
    submissions = _select_importable(db, account_id, exercises, utc_now())
    rows = db.execute(select(Submission.exercise, Submission.created_at).where(Submission.id.in_(submissions)))
    return {row.exercise: row.created_at for row in rows}


def _select_importable(
    db: Session, account_id: UUID, exercises: Collection[str], before: datetime
) -> Select[tuple[UUID]]:
    """Select in each exercise the last attempt with full marks sent before a time, whose verdict is not withheld."""
    order = (Submission.created_at.desc(), Submission.id.desc())
    ranked = (
        select(Submission.id, func.row_number().over(partition_by=Submission.exercise, order_by=order).label("rank"))
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id == account_id, Grading.outcome == Outcome.OK, Submission.created_at < before)
        .where(or_(*_conditions_not_withheld(db, account_id, exercises)))
        .subquery()
    )
    return select(ranked.c.id).where(ranked.c.rank == 1)


def _conditions_not_withheld(db: Session, account_id: UUID, exercises: Collection[str]) -> list[ColumnElement[bool]]:
    """Return conditions for attempts whose verdict is not withheld: an import must not reveal it."""
    held_since = {
        exercise: holds.held_since for exercise, holds in feedback.load_holds_by_exercise(db, account_id).items()
    }
    free = [exercise for exercise in exercises if held_since.get(exercise) is None]
    earlier = [
        and_(Submission.exercise == exercise, Submission.created_at < since)
        for exercise in exercises
        if (since := held_since.get(exercise)) is not None
    ]
    return [Submission.exercise.in_(free), *earlier]
