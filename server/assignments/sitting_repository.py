"""Queries on sittings and on the work saved in them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import and_, func, or_, select, update
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Assignment, EndedBy, Mode, SavedWork, Sitting
from server.classes.models import Membership
from server.database import upsert_statement


@dataclass(frozen=True)
class UnfinishedSitting:
    """A sitting whose row is not ended yet, with its assignment and the student's labels, which decide its end."""

    sitting: Sitting
    assignment: Assignment
    groups: Sequence[str]


def load_sitting(db: Session, assignment_id: UUID, account_id: UUID) -> Sitting | None:
    return db.get(Sitting, (assignment_id, account_id))


def lock_sitting(db: Session, assignment_id: UUID, account_id: UUID) -> Sitting | None:
    """Lock and reload a sitting: until the commit nobody else ends it, nor submits or saves in it."""
    query = select(Sitting).where(Sitting.assignment_id == assignment_id, Sitting.account_id == account_id)
    query = query.with_for_update().execution_options(populate_existing=True)
    return db.execute(query).scalar_one_or_none()


def insert_sitting_once(db: Session, assignment_id: UUID, account_id: UUID, now: datetime) -> None:
    """Insert a sitting unless it exists: of two tabs, the first one's time holds."""
    row = {"assignment_id": assignment_id, "account_id": account_id, "began_at": now}
    db.execute(upsert_statement(db, Sitting).on_conflict_do_nothing(), row)


def upsert_saved_work(
    db: Session, assignments: Collection[UUID], account_id: UUID, exercise: str, source: bytes, now: datetime
) -> None:
    """Save work in these tests, replacing what was saved before."""
    key = ("assignment_id", "account_id", "exercise")
    for assignment_id in assignments:
        row = {"assignment_id": assignment_id, "account_id": account_id, "exercise": exercise}
        work = {"source": source, "saved_at": now}
        statement = upsert_statement(db, SavedWork).on_conflict_do_update(index_elements=key, set_=work)
        db.execute(statement, {**row, **work})


def load_saved_work(db: Session, assignment_id: UUID, account_id: UUID) -> Sequence[SavedWork]:
    query = select(SavedWork).where(SavedWork.assignment_id == assignment_id, SavedWork.account_id == account_id)
    return db.execute(query.order_by(SavedWork.exercise)).scalars().all()


def load_last_save_times(db: Session, assignment_id: UUID, account_id: UUID) -> Mapping[str, datetime]:
    """Return when each exercise was saved last."""
    query = select(SavedWork.exercise, SavedWork.saved_at)
    query = query.where(SavedWork.assignment_id == assignment_id, SavedWork.account_id == account_id)
    return dict(db.execute(query).all())


def load_exercises_in_sat_tests(db: Session, account_id: UUID, at: datetime) -> frozenset[str]:
    """Return the exercises of the tests that an account sat at a time."""
    query = (
        select(AssignedExercise.exercise)
        .join(Assignment, Assignment.id == AssignedExercise.assignment_id)
        .join(Sitting, Sitting.assignment_id == Assignment.id)
        .where(Sitting.account_id == account_id, Assignment.mode == Mode.test, Sitting.began_at <= at)
        .where(or_(Sitting.handed_in_at.is_(None), Sitting.handed_in_at >= at))
    )
    return frozenset(db.execute(query).scalars())


def load_last_saved_work(
    db: Session, assignments: Collection[UUID], account_id: UUID, exercise: str
) -> SavedWork | None:
    query = select(SavedWork).where(
        SavedWork.assignment_id.in_(assignments), SavedWork.account_id == account_id, SavedWork.exercise == exercise
    )
    return db.execute(query.order_by(SavedWork.saved_at.desc()).limit(1)).scalar_one_or_none()


def load_all_saved_work(db: Session, account_id: UUID) -> Sequence[SavedWork]:
    query = select(SavedWork).where(SavedWork.account_id == account_id)
    return db.execute(query.order_by(SavedWork.assignment_id, SavedWork.exercise)).scalars().all()


def load_account_sittings(db: Session, account_id: UUID) -> Sequence[tuple[Sitting, str]]:
    """Load an account's sittings, each with the title of its test, oldest first."""
    query = select(Sitting, Assignment.title).join(Assignment, Assignment.id == Sitting.assignment_id)
    rows = db.execute(query.where(Sitting.account_id == account_id).order_by(Sitting.began_at))
    return [(sitting, title) for sitting, title in rows]


def load_unfinished_sittings(db: Session, assignment_id: UUID | None = None) -> Sequence[UnfinishedSitting]:
    """Load the unfinished sittings of one test, or of all tests."""
    query = (
        select(Sitting, Assignment, Membership.groups)
        .join(Assignment, Assignment.id == Sitting.assignment_id)
        .outerjoin(
            Membership,
            and_(Membership.class_id == Assignment.class_id, Membership.account_id == Sitting.account_id),
        )
        .where(Sitting.handed_in_at.is_(None))
    )
    query = query if assignment_id is None else query.where(Sitting.assignment_id == assignment_id)
    return [UnfinishedSitting(sitting, assignment, groups or ()) for sitting, assignment, groups in db.execute(query)]


def load_sittings(db: Session, assignments: Collection[UUID]) -> Mapping[tuple[UUID, UUID], Sitting]:
    """Load the sittings of these assignments, by assignment and account."""
    query = select(Sitting).where(Sitting.assignment_id.in_(assignments))
    return {(sitting.assignment_id, sitting.account_id): sitting for sitting in db.execute(query).scalars()}


def count_begun_and_ended_sittings(db: Session, assignment_id: UUID) -> tuple[int, int]:
    """Count the sittings that have begun, and those of them that have ended."""
    query = select(func.count(), func.count(Sitting.handed_in_at)).where(Sitting.assignment_id == assignment_id)
    begun, ended = db.execute(query).one()
    return begun, ended


def end_sitting(db: Session, sitting: Sitting, at: datetime, by: EndedBy) -> None:
    sitting.handed_in_at, sitting.ended_by = at, by
    db.flush()


def has_common_sitting(db: Session, first_id: UUID, second_id: UUID) -> bool:
    """Whether two accounts have begun the same test."""
    own = select(Sitting.assignment_id).where(Sitting.account_id == first_id)
    query = select(Sitting.assignment_id).where(Sitting.account_id == second_id, Sitting.assignment_id.in_(own))
    return db.execute(query.limit(1)).first() is not None


def move_sittings(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's sittings and saved work to an account, except for tests that the account sat itself."""
    for model in (SavedWork, Sitting):
        own = select(Sitting.assignment_id).where(Sitting.account_id == account_id)
        moved = update(model).where(model.account_id == guest_id, model.assignment_id.not_in(own))
        db.execute(moved.values(account_id=account_id).execution_options(synchronize_session=False))
