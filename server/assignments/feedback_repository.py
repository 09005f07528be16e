"""Queries on the assignments that may hold back feedback from an account."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cache
from typing import TypeAlias
from uuid import UUID

from sqlalchemy import BindParameter, ColumnElement, Row, Select, Uuid, and_, bindparam, exists, or_, select
from sqlalchemy.orm import InstrumentedAttribute, Session

from server.assignments.models import AssignedExercise, Assignment, Exemption, Mode, Sitting, Visibility
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import UtcDateTime

HoldingRows: TypeAlias = Select[UUID, Assignment, str, list[str], str, Sitting]


@dataclass(frozen=True)
class AssignedExerciseRow:
    """An exercise of an assignment in a student's class, with their membership and their sitting."""

    account_id: UUID
    assignment: Assignment
    exercise: str
    groups: Sequence[str]
    active: bool
    sitting: Sitting | None


def _select_holding_rows(now: datetime | BindParameter[datetime]) -> HoldingRows:
    """Select the assigned exercises that may hold back feedback, with the student and their sitting.

    Includes classes that a student left voluntarily: leaving a class, or asking to come back, does not end a test.
    Excludes assignments that hold nothing back and tests that are over for everyone. An archived class holds back only
    the tests that were sat in it and are not released.
    """
    later = exists().where(
        Exemption.assignment_id == Assignment.id,
        Exemption.revoked_at.is_(None),
        Exemption.opens_at > Assignment.released_at,
    )
    sits = and_(Sitting.began_at.is_not(None), or_(Sitting.handed_in_at.is_(None), Sitting.ended_by == "time"))
    unreleased = or_(Assignment.released_at.is_(None), Assignment.released_at > now, sits, later)
    hides = or_(
        *(column != Visibility.usual for column in (Assignment.hints, Assignment.diagnosis, Assignment.solution))
    )
    return (
        select(
            Membership.account_id, Assignment, AssignedExercise.exercise, Membership.groups, Membership.status, Sitting
        )
        .select_from(Membership)
        .join(Assignment, Assignment.class_id == Membership.class_id)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .join(AssignedExercise, AssignedExercise.assignment_id == Assignment.id)
        .outerjoin(
            Sitting,
            and_(Sitting.assignment_id == Assignment.id, Sitting.account_id == Membership.account_id),
        )
        .where(
            Membership.role == ClassRole.student,
            Assignment.removed_at.is_(None),
            or_(
                Membership.status == Status.active,
                and_(Membership.status == Status.left, Membership.left_voluntarily),
                and_(Membership.status == Status.pending, Sitting.began_at.is_not(None)),
            ),
            or_(SchoolClass.archived_at.is_(None), Sitting.began_at.is_not(None)),
            or_(and_(Assignment.mode == Mode.test, unreleased), and_(hides, SchoolClass.archived_at.is_(None))),
        )
    )


def has_holds_clause(
    account_id: InstrumentedAttribute[UUID], exercise: InstrumentedAttribute[str], now: datetime
) -> ColumnElement[bool]:
    """Return an EXISTS clause: something may be held for the account and the exercise in these columns of a query."""
    query = _select_holding_rows(now).where(Membership.account_id == account_id, AssignedExercise.exercise == exercise)
    return query.with_only_columns(Assignment.id, maintain_column_froms=True).exists()


@cache
def _rows_of_account() -> HoldingRows:
    """Built once: every attempt and every page of an exercise asks."""
    query = _select_holding_rows(bindparam("now", type_=UtcDateTime()))
    return query.where(Membership.account_id == bindparam("account_id", type_=Uuid()))


@cache
def _rows_of_account_and_exercise() -> HoldingRows:
    return _rows_of_account().where(AssignedExercise.exercise == bindparam("exercise"))


def load_student_rows(
    db: Session, account_id: UUID, exercise: str | None, now: datetime
) -> Sequence[AssignedExerciseRow]:
    """Load the rows of an account, in one exercise or in all."""
    values = {"now": now, "account_id": account_id, "exercise": exercise}
    return _rows(db.execute(_rows_of_account() if exercise is None else _rows_of_account_and_exercise(), values))


def load_rows_of_students(
    db: Session, accounts: Collection[UUID], exercise: str, now: datetime
) -> Sequence[AssignedExerciseRow]:
    """Load the rows of several accounts in one exercise."""
    query = _select_holding_rows(now).where(AssignedExercise.exercise == exercise)
    return _rows(db.execute(query.where(Membership.account_id.in_(accounts))))


def _rows(rows: Iterable[Row[UUID, Assignment, str, list[str], str, Sitting]]) -> Sequence[AssignedExerciseRow]:
    return [
        AssignedExerciseRow(account_id, assignment, name, groups, status == Status.active, sitting)
        for account_id, assignment, name, groups, status, sitting in rows
    ]
