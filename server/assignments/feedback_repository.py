"""Queries on the assignments that may hold back feedback from an account."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Row, Select, Table, Uuid, and_, bindparam, exists, or_, select
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Assignment, Exemption, Mode, Sitting, Visibility
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import UtcDateTime, select_core


@dataclass(frozen=True)
class AssignedExerciseRow:
    """An exercise of an assignment in a student's class, with their membership and their sitting."""

    account_id: UUID
    assignment: Assignment
    exercise: str
    groups: Sequence[str]
    active: bool
    sitting: Sitting | None


def _select_withholding_rows() -> Select[UUID, Assignment, str, list[str], str, Sitting]:
    """Select the assigned exercises that may hold back feedback, with the student and their sitting.

    Includes classes that a student left voluntarily: leaving a class, or asking to come back, does not end a test.
    Excludes assignments that hold nothing back and tests that are over for everyone. An archived class holds back only
    the tests that were sat in it and are not released.
    """
    now = bindparam("now", type_=UtcDateTime())
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


#: On the hot path of every page and attempt: built once.
ALL_ROWS = _select_withholding_rows()
#: The type is explicit: the column takes its own from the account table, which may not be imported yet.
ACCOUNT_ROWS = ALL_ROWS.where(Membership.account_id == bindparam("account", type_=Uuid()))
EXERCISE_ROWS = ACCOUNT_ROWS.where(AssignedExercise.exercise == bindparam("exercise"))
#: Mostly nothing is held: selecting one column takes half the time.
ANY_EXERCISE_ROW = EXERCISE_ROWS.with_only_columns(Assignment.id, maintain_column_froms=True).limit(1)


def has_holds_clause(table: Table) -> ColumnElement[bool]:
    """Return an EXISTS clause: something may be held for the account and the exercise of a row of this table.

    The statement needs the value `now`.
    """
    row = table.c
    query = ALL_ROWS.where(Membership.account_id == row.account_id, AssignedExercise.exercise == row.exercise)
    return query.with_only_columns(Assignment.id, maintain_column_froms=True).correlate(table).exists()


def load_student_rows(
    db: Session, account_id: UUID, exercise: str | None, now: datetime
) -> Sequence[AssignedExerciseRow]:
    """Load the rows of an account, in one exercise or in all."""
    values = {"account": account_id, "now": now}
    if exercise is None:
        return _build_rows(db.execute(ACCOUNT_ROWS, values))
    exercise_values = {**values, "exercise": exercise}
    return (
        ()
        if select_core(db, ANY_EXERCISE_ROW, exercise_values).first() is None
        else _build_rows(db.execute(EXERCISE_ROWS, exercise_values))
    )


def load_students_rows(
    db: Session, accounts: Collection[UUID], exercise: str, now: datetime
) -> Sequence[AssignedExerciseRow]:
    """Load the rows of several accounts in one exercise."""
    query = ALL_ROWS.where(AssignedExercise.exercise == exercise, Membership.account_id.in_(accounts))
    return _build_rows(db.execute(query, {"now": now}))


def _build_rows(rows: Iterable[Row[UUID, Assignment, str, list[str], str, Sitting]]) -> Sequence[AssignedExerciseRow]:
    return [
        AssignedExerciseRow(account_id, assignment, name, groups, status == Status.active, sitting)
        for account_id, assignment, name, groups, status, sitting in rows
    ]
