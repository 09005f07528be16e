"""Queries on lessons, on the students seen in them, and on the sources that a lesson's page compares."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime, timedelta
from typing import NamedTuple
from uuid import UUID

from sqlalchemy import and_, or_, select, update
from sqlalchemy.orm import Session

from server.classes.models import SchoolClass
from server.database import upsert_statement
from server.identity.models import Account
from server.lesson.models import LONGEST_LESSON, LessonVisit, LiveLesson
from server.submissions.models import Submission

MAX_LESSONS = 60


def find_latest_lesson(db: Session, class_id: UUID) -> LiveLesson | None:
    """Return the lesson that began last, whether it goes on or not."""
    query = select(LiveLesson).where(LiveLesson.class_id == class_id)
    return db.execute(query.order_by(LiveLesson.started_at.desc(), LiveLesson.id).limit(1)).scalar_one_or_none()


def find_lesson(db: Session, class_id: UUID, lesson_id: UUID) -> LiveLesson | None:
    query = select(LiveLesson).where(LiveLesson.class_id == class_id, LiveLesson.id == lesson_id)
    return db.execute(query).scalar_one_or_none()


def load_lessons(db: Session, class_id: UUID) -> Sequence[LiveLesson]:
    """Load the latest lessons of a class, newest first."""
    query = select(LiveLesson).where(LiveLesson.class_id == class_id)
    return db.execute(query.order_by(LiveLesson.started_at.desc(), LiveLesson.id).limit(MAX_LESSONS)).scalars().all()


def load_earlier_lessons(db: Session, lesson: LiveLesson, memory: timedelta) -> Sequence[LiveLesson]:
    """Load the lessons of the class that began before this one, but not longer before, the newest first."""
    query = select(LiveLesson).where(LiveLesson.class_id == lesson.class_id, LiveLesson.started_at < lesson.started_at)
    recent = query.where(LiveLesson.started_at >= lesson.started_at - memory)
    return db.execute(recent.order_by(LiveLesson.started_at.desc(), LiveLesson.id).limit(MAX_LESSONS)).scalars().all()


def load_lessons_ended_between(
    db: Session, class_ids: Collection[UUID], since: datetime, now: datetime
) -> Sequence[LiveLesson]:
    """Load the lessons of these classes that ended between two moments; one that nobody ends lasts `LONGEST_LESSON`."""
    by_hand = and_(LiveLesson.ended_at > since, LiveLesson.ended_at <= now)
    by_time = and_(
        LiveLesson.ended_at.is_(None),
        LiveLesson.started_at > since - LONGEST_LESSON,
        LiveLesson.started_at <= now - LONGEST_LESSON,
    )
    query = select(LiveLesson).where(LiveLesson.class_id.in_(class_ids), or_(by_hand, by_time))
    return db.execute(query.order_by(LiveLesson.started_at, LiveLesson.id)).scalars().all()


class StudentVisit(NamedTuple):
    """When a student was seen last in a lesson, at which exercise, and the name of who did, empty where unknown."""

    exercise: str
    visited_at: datetime
    visitor: str


def save_visit(db: Session, lesson_id: UUID, account_id: UUID, exercise: str, at: datetime, by: UUID) -> None:
    row = {"exercise": exercise, "visited_at": at, "visited_by": by}
    statement = upsert_statement(db, LessonVisit).values(lesson_id=lesson_id, account_id=account_id, **row)
    db.execute(statement.on_conflict_do_update(index_elements=["lesson_id", "account_id"], set_=row))


def load_visits(db: Session, lesson_id: UUID) -> Mapping[UUID, StudentVisit]:
    """Load the visits of a lesson, by student."""
    columns = LessonVisit.account_id, LessonVisit.exercise, LessonVisit.visited_at, Account.name
    query = select(*columns).outerjoin(Account, Account.id == LessonVisit.visited_by)
    rows = db.execute(query.where(LessonVisit.lesson_id == lesson_id))
    return {account: StudentVisit(exercise, at, name or "") for account, exercise, at, name in rows}


def load_account_visits(db: Session, account_id: UUID) -> Sequence[tuple[LessonVisit, str]]:
    """Load when an account was seen in lessons, each with the name of its class."""
    query = (
        select(LessonVisit, SchoolClass.name)
        .join(LiveLesson, LiveLesson.id == LessonVisit.lesson_id)
        .join(SchoolClass, SchoolClass.id == LiveLesson.class_id)
        .where(LessonVisit.account_id == account_id)
    )
    return [(visit, name) for visit, name in db.execute(query.order_by(LessonVisit.visited_at))]


def load_lessons_started_by(db: Session, account_id: UUID) -> Sequence[tuple[LiveLesson, str]]:
    """Load the lessons that an account began, each with the name of its class."""
    query = select(LiveLesson, SchoolClass.name).join(SchoolClass, SchoolClass.id == LiveLesson.class_id)
    query = query.where(LiveLesson.started_by == account_id).order_by(LiveLesson.started_at)
    return [(lesson, name) for lesson, name in db.execute(query)]


def move_visits(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move the visits to a guest to an account, except in lessons in which the account was seen already."""
    own = select(LessonVisit.lesson_id).where(LessonVisit.account_id == account_id)
    moved = update(LessonVisit).where(LessonVisit.account_id == guest_id, LessonVisit.lesson_id.not_in(own))
    db.execute(moved.values(account_id=account_id).execution_options(synchronize_session=False))


def load_submission_sources(db: Session, submissions: Collection[UUID]) -> Mapping[UUID, bytes]:
    query = select(Submission.id, Submission.source).where(Submission.id.in_(submissions))
    return {row[0]: row[1] for row in db.execute(query)}
