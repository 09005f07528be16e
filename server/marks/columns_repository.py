"""Queries on manual columns and their marks."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from uuid import UUID

from sqlalchemy import Row, and_, delete, func, select, update
from sqlalchemy.orm import Session

from server.classes.models import SchoolClass
from server.marks.models import ManualColumn, ManualMark
from server.marks.schemas import ColumnRecord, TypedMark
from server.marks.states import TypedState

TypedMarks = Mapping[tuple[UUID, UUID], TypedMark]


def load_columns_and_marks(
    db: Session, class_id: UUID, students: Collection[UUID] | None = None
) -> tuple[Sequence[ColumnRecord], TypedMarks]:
    """Load the columns of a class in order, deleted ones left out, and the marks by column and student: one query."""
    join = ManualMark.column_id == ManualColumn.id
    if students is not None:
        join = and_(join, ManualMark.account_id.in_(students))
    query = (
        select(ManualColumn, ManualMark)
        .outerjoin(ManualMark, join)
        .where(ManualColumn.class_id == class_id, ManualColumn.deleted_at.is_(None))
        .order_by(ManualColumn.position, ManualColumn.created_at, ManualColumn.id)
    )
    columns: dict[UUID, ColumnRecord] = {}
    marks: dict[tuple[UUID, UUID], TypedMark] = {}
    for column, mark in db.execute(query):
        if column.id not in columns:
            columns[column.id] = build_column_record(column)
        if mark is not None:
            marks[column.id, mark.account_id] = build_typed_mark(mark)
    return list(columns.values()), marks


def build_column_record(column: ManualColumn) -> ColumnRecord:
    return ColumnRecord(
        id=column.id,
        title=column.title,
        out_of=column.out_of,
        taken_on=column.taken_on,
        weight=column.weight,
        bonus=column.bonus,
        published_at=column.published_at,
        version=column.version,
    )


def build_typed_mark(mark: ManualMark) -> TypedMark:
    state = None if mark.state is None else TypedState(mark.state)
    return TypedMark(mark.points, state, mark.comment, mark.version)


def find_column(db: Session, class_id: UUID, column_id: UUID) -> ManualColumn | None:
    """Return a column of this class, deleted or not."""
    query = select(ManualColumn).where(ManualColumn.id == column_id, ManualColumn.class_id == class_id)
    return db.execute(query).scalar_one_or_none()


def list_columns(db: Session, class_id: UUID, *, deleted: bool = False) -> Sequence[ManualColumn]:
    """Return the columns of a class in order; with `deleted` those that were deleted, newest first."""
    query = select(ManualColumn).where(ManualColumn.class_id == class_id)
    if deleted:
        query = query.where(ManualColumn.deleted_at.is_not(None)).order_by(ManualColumn.deleted_at.desc())
    else:
        query = query.where(ManualColumn.deleted_at.is_(None)).order_by(ManualColumn.position, ManualColumn.created_at)
    return db.execute(query.order_by(ManualColumn.id)).scalars().all()


def count_columns_with_deleted(db: Session, class_id: UUID) -> int:
    """Count the columns of a class, deleted ones included."""
    query = select(func.count()).select_from(ManualColumn).where(ManualColumn.class_id == class_id)
    return db.execute(query).scalar_one()


def load_column_marks(db: Session, column_id: UUID) -> Mapping[UUID, ManualMark]:
    """Load the marks of a column, by student."""
    rows = db.execute(select(ManualMark).where(ManualMark.column_id == column_id)).scalars()
    return {row.account_id: row for row in rows}


def load_account_marks(db: Session, account_id: UUID) -> Sequence[Row[ManualMark, ManualColumn, str]]:
    """Return every mark of an account in a column, each with its column and the name of the class."""
    query = (
        select(ManualMark, ManualColumn, SchoolClass.name)
        .join(ManualColumn, ManualColumn.id == ManualMark.column_id)
        .join(SchoolClass, SchoolClass.id == ManualColumn.class_id)
        .where(ManualMark.account_id == account_id)
    )
    return db.execute(query.order_by(ManualColumn.created_at, ManualColumn.id)).all()


def move_column_marks(db: Session, old: UUID, new: UUID) -> None:
    """Move marks from a guest to an account, which keeps its own where both have one."""
    own = select(ManualMark.column_id).where(ManualMark.account_id == new)
    of_guest = ManualMark.account_id == old
    db.execute(
        delete(ManualMark).where(of_guest, ManualMark.column_id.in_(own)).execution_options(synchronize_session=False)
    )
    db.execute(update(ManualMark).where(of_guest).values(account_id=new))
