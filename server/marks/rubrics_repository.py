"""Queries on rubrics, and on the copies that are marked by them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple
from uuid import UUID

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from server.classes.models import SchoolClass
from server.marks.models import ManualColumn, Rubric, RubricMarking
from server.marks.rubric_items import RubricItem, RubricScores


def find_rubric(db: Session, assignment_id: UUID) -> tuple[Rubric, ManualColumn] | None:
    """Return the rubric of an assignment with its column, unless that is deleted."""
    query = (
        select(Rubric, ManualColumn)
        .join(ManualColumn, ManualColumn.id == Rubric.column_id)
        .where(Rubric.assignment_id == assignment_id, ManualColumn.deleted_at.is_(None))
        .order_by(ManualColumn.created_at.desc())
    )
    row = db.execute(query.limit(1)).first()
    return None if row is None else (row[0], row[1])


def find_rubric_of_column(db: Session, column_id: UUID) -> Rubric | None:
    return db.get(Rubric, column_id)


def load_rubric_titles(db: Session, assignments: Collection[UUID]) -> Mapping[UUID, tuple[str, bool]]:
    """Load the title of the column of each assignment's rubric, and whether it is published."""
    query = (
        select(Rubric.assignment_id, ManualColumn.title, ManualColumn.published_at)
        .join(ManualColumn, ManualColumn.id == Rubric.column_id)
        .where(Rubric.assignment_id.in_(assignments), ManualColumn.deleted_at.is_(None))
    )
    return {assignment: (title, published is not None) for assignment, title, published in db.execute(query)}


def read_rubric_items(rubric: Rubric) -> tuple[RubricItem, ...]:
    return tuple(RubricItem.from_json(row) for row in rubric.items)


def read_rubric_scores(marking: RubricMarking) -> RubricScores:
    return RubricScores(dict(marking.points), dict(marking.remarks))


def load_rubric_markings(db: Session, column_id: UUID) -> Mapping[UUID, RubricMarking]:
    """Load the copies of a rubric that are marked or begun, by student."""
    rows = db.execute(select(RubricMarking).where(RubricMarking.column_id == column_id)).scalars()
    return {row.account_id: row for row in rows}


def find_rubric_marking(db: Session, column_id: UUID, student: UUID) -> RubricMarking | None:
    return db.get(RubricMarking, (column_id, student))


class AccountMarking(NamedTuple):
    """A copy that is marked or begun, with its rubric, its column and the name of the class."""

    marking: RubricMarking
    rubric: Rubric
    column: ManualColumn
    class_name: str


def load_account_markings(db: Session, account_id: UUID) -> Sequence[AccountMarking]:
    """Return every copy of an account that is marked or begun."""
    query = (
        select(RubricMarking, Rubric, ManualColumn, SchoolClass.name)
        .join(Rubric, Rubric.column_id == RubricMarking.column_id)
        .join(ManualColumn, ManualColumn.id == Rubric.column_id)
        .join(SchoolClass, SchoolClass.id == ManualColumn.class_id)
        .where(RubricMarking.account_id == account_id)
    )
    rows = db.execute(query.order_by(ManualColumn.created_at, ManualColumn.id))
    return [AccountMarking(*row) for row in rows]


def move_rubric_markings(db: Session, old: UUID, new: UUID) -> None:
    """Move markings from a guest to an account, which keeps its own where both have one."""
    own = select(RubricMarking.column_id).where(RubricMarking.account_id == new)
    of_guest = RubricMarking.account_id == old
    duplicates = delete(RubricMarking).where(of_guest, RubricMarking.column_id.in_(own))
    db.execute(duplicates.execution_options(synchronize_session=False))
    db.execute(update(RubricMarking).where(of_guest).values(account_id=new))
