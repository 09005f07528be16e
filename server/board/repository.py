"""Queries on what the students of a class have sent: each answers for all of them at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, and_, select
from sqlalchemy.orm import Session

from graders.core.contract.outcomes import Outcome
from server.classes.models import ClassRole, Membership, Status
from server.gradebook.histories import REVISION_SUMS, Revisions
from server.gradebook.models import Grading
from server.submissions.models import Submission


@dataclass(frozen=True)
class BoardScope:
    """The exercises that count on the board of a class, and until when (None: until now).

    `groups_by_exercise`: pairs of an exercise that is given to some groups only and the labels of these groups.
    """

    class_id: UUID
    exercises: tuple[str, ...]
    until: datetime | None
    groups_by_exercise: tuple[tuple[str, frozenset[str]], ...] = ()


@dataclass(frozen=True)
class ClassVersionTag:
    """A version tag of a class: it changes when an attempt of a student is graded, and when members change.

    `revisions`: the tags of the students' attempts; `students`: those without attempts too. `others`: tags of what else
    a view of the class shows.
    """

    revisions: Revisions
    students: tuple[UUID, ...]
    others: tuple[object, ...] = ()


def load_class_version_tag(db: Session, class_id: UUID) -> ClassVersionTag:
    graded = and_(Submission.account_id == Membership.account_id, Submission.revision.is_not(None))
    query = select(Membership.account_id, *REVISION_SUMS).outerjoin(Submission, graded)
    query = (
        query.where(*_active_student_conditions(class_id))
        .group_by(Membership.account_id)
        .order_by(Membership.account_id)
    )
    rows = db.execute(query).all()
    revisions = {account_id: (int(low), int(high)) for account_id, low, high in rows if low is not None}
    return ClassVersionTag(revisions, tuple(row[0] for row in rows))


@dataclass(frozen=True)
class SubmittedSource:
    """The source of a submission, and its student."""

    account: UUID
    submission: UUID
    source: bytes


def load_sources_with_misconception(
    db: Session, scope: BoardScope, exercise: str, misconception: str, limit: int
) -> Sequence[SubmittedSource]:
    """Load the latest attempts at an exercise that show a misconception, newest first."""
    return _load_latest_sources(db, scope, exercise, Grading.diagnosis == misconception, limit)


def load_successful_sources(db: Session, scope: BoardScope, exercise: str, limit: int) -> Sequence[SubmittedSource]:
    """Load the latest successful attempts at an exercise, newest first."""
    return _load_latest_sources(db, scope, exercise, Grading.outcome == Outcome.OK.value, limit)


def _load_latest_sources(
    db: Session, scope: BoardScope, exercise: str, wanted: ColumnElement[bool], limit: int
) -> Sequence[SubmittedSource]:
    query = (
        select(Submission.account_id, Submission.id, Submission.source)
        .join(Grading, Grading.id == Submission.grading_id)
        .join(Membership, Membership.account_id == Submission.account_id)
        .where(
            *_active_student_conditions(scope.class_id),
            Submission.exercise == exercise,
            Submission.exercise.in_(scope.exercises),
            wanted,
            Grading.score.is_not(None),
        )
        .order_by(Submission.created_at.desc(), Submission.id.desc())
    )
    if scope.until is not None:
        query = query.where(Submission.created_at <= scope.until)
    return [SubmittedSource(*row) for row in db.execute(query.limit(limit))]


def _active_student_conditions(class_id: UUID) -> tuple[ColumnElement[bool], ...]:
    return (
        Membership.class_id == class_id,
        Membership.role == ClassRole.student,
        Membership.status == Status.active,
    )
