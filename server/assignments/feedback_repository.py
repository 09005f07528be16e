"""Queries on what an account's assignments may hold back."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Select, Table, Uuid, and_, bindparam, exists, or_, select
from sqlalchemy import Row as Found
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Assignment, Exemption, Mode, Sitting, Visibility
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import UtcDateTime, ask


@dataclass(frozen=True)
class AssignedExerciseRow:
    """One exercise of one assignment of one of a student's classes, with what that student is there and has done."""

    account_id: UUID
    assignment: Assignment
    exercise: str
    groups: Sequence[str]
    active: bool
    sitting: Sitting | None


def _asked() -> Select[UUID, Assignment, str, list[str], str, Sitting]:
    """Of the classes where an account learns, or which it has left of its own accord: nobody leaves a test so, nor by
    asking to come back.

    An assignment that holds nothing back is left out, and so is a test that is over for everyone. A class that is
    archived holds nothing back but the tests that were sat in it and are not released.
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
            or_(
                Membership.status == Status.active,
                and_(Membership.status == Status.left, Membership.left_voluntarily),
                and_(Membership.status == Status.pending, Sitting.began_at.is_not(None)),
            ),
            or_(SchoolClass.archived_at.is_(None), Sitting.began_at.is_not(None)),
            or_(and_(Assignment.mode == Mode.test, unreleased), and_(hides, SchoolClass.archived_at.is_(None))),
        )
    )


#: Asked with every page and every attempt: made once.
OF_EVERYONE = _asked()
#: The type is said, since the column takes its own from the accounts, which need not have been imported yet.
OF_ALL = OF_EVERYONE.where(Membership.account_id == bindparam("account", type_=Uuid()))
OF_ONE = OF_ALL.where(AssignedExercise.exercise == bindparam("exercise"))
#: Nothing is, for most and most of the time: asked for one column, it takes half as long.
ANY_OF_ONE = OF_ONE.with_only_columns(Assignment.id, maintain_column_froms=True).limit(1)


def has_holds_clause(table: Table) -> ColumnElement[bool]:
    """Whether there is something for the account and the exercise of a row of this table, to be asked with the row. The
    time is the value `now`."""
    row = table.c
    query = OF_EVERYONE.where(Membership.account_id == row.account_id, AssignedExercise.exercise == row.exercise)
    return query.with_only_columns(Assignment.id, maintain_column_froms=True).correlate(table).exists()


def load_student_rows(
    db: Session, account_id: UUID, exercise: str | None, now: datetime
) -> Sequence[AssignedExerciseRow]:
    """In one exercise, or in all."""
    values = {"account": account_id, "now": now}
    if exercise is None:
        return _rows(db.execute(OF_ALL, values))
    in_it = {**values, "exercise": exercise}
    return () if ask(db, ANY_OF_ONE, in_it).first() is None else _rows(db.execute(OF_ONE, in_it))


def load_rows_of_students(
    db: Session, accounts: Collection[UUID], exercise: str, now: datetime
) -> Sequence[AssignedExerciseRow]:
    """In one exercise, of many."""
    query = OF_EVERYONE.where(AssignedExercise.exercise == exercise, Membership.account_id.in_(accounts))
    return _rows(db.execute(query, {"now": now}))


def _rows(found: Iterable[Found[UUID, Assignment, str, list[str], str, Sitting]]) -> Sequence[AssignedExerciseRow]:
    return [
        AssignedExerciseRow(account_id, assignment, name, groups, status == Status.active, sitting)
        for account_id, assignment, name, groups, status, sitting in found
    ]
