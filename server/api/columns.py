"""Columns of a teacher's own in the gradebook of a class: an oral, a paper test, participation."""

from dataclasses import asdict
from typing import Annotated, Any
from uuid import UUID

from fastapi import APIRouter, Query, Response

from server.api.column_schemas import (
    ColumnChange,
    ColumnIn,
    ColumnOut,
    ColumnWithMarks,
    TypedMarkIn,
    TypedMarksIn,
)
from server.api.documentation import problem_responses
from server.base.errors import Conflict, Invalid, NotFound
from server.base.validation import parse_uuid
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.service import NOT_A_MEMBER
from server.database.dependencies import Db
from server.identity.dependencies import ApiAccount
from server.marks import columns
from server.marks import columns_repository as repository
from server.marks.columns import MarkEntry
from server.marks.models import ManualColumn
from server.marks.schemas import NEVER_TYPED, TypedMark
from server.marks.states import TypedState
from server.marks.typed import ColumnInput
from server.rights import service as rights
from server.rights.models import Right

router = APIRouter(tags=["columns"])

ALL = "/classes/{class_id}/columns"
ONE = "/classes/{class_id}/columns/{column_id}"
FIELDS = ("title", "out_of", "taken_on", "weight", "bonus")
POINTS_OR_STATE = "Donnez des points, ou un état : l’un des deux."


@router.get(ALL, responses=problem_responses(401, 403, 404, 422))
def list_columns(
    class_id: str, account: ApiAccount, db: Db,
    deleted: Annotated[bool, Query(description="Those that were deleted, newest first.")] = False,
) -> list[ColumnOut]:  # fmt: skip
    """The columns of a class, in order."""
    place = rights.require_right(db, account, Right.read_marks, class_id)
    return [_column_out(column) for column in repository.list_columns(db, place.school_class.id, deleted=deleted)]


@router.post(ALL, status_code=201, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def create_column(class_id: str, body: ColumnIn, account: ApiAccount, db: Db) -> ColumnOut:
    """Adds a column after the others. Students see it once it is published."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    fields = ColumnInput(**{name: getattr(body, name) for name in FIELDS})
    column = columns.create_column(db, place.school_class, account, fields)
    columns.set_column_published(db, place.school_class, account, column.id, published=body.published)
    return _column_out(column)


@router.get(ONE, responses=problem_responses(401, 403, 404))
def read_column(class_id: str, column_id: str, account: ApiAccount, db: Db) -> ColumnWithMarks:
    """A column, with the marks of all students."""
    place = rights.require_right(db, account, Right.read_marks, class_id)
    return _column_with_marks(
        db, place.school_class, columns.find_column(db, place.school_class, _parse_column_id(column_id))
    )


@router.patch(ONE, responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def change_column(class_id: str, column_id: str, body: ColumnChange, account: ApiAccount, db: Db) -> ColumnOut:
    """Changes what is sent, and leaves the rest. The marks stay."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    school_class, name = place.school_class, _parse_column_id(column_id)
    column = columns.lock_column(db, school_class, name)
    if body.version is not None and body.version != column.version:
        raise Conflict(columns.COLUMN_CHANGED)
    sent = {field: getattr(body, field) for field in body.model_fields_set & set(FIELDS)}
    told: dict[str, Any] = {field: value for field, value in sent.items() if value is not None or field == "taken_on"}
    columns.change_column(
        db, school_class, account, name, ColumnInput(**{**asdict(columns.editable_column_fields(column)), **told})
    )
    if body.published is not None:
        columns.set_column_published(db, school_class, account, name, published=body.published)
    if body.place is not None:
        columns.move_column(db, school_class, account, name, body.place)
    return _column_out(column)


@router.delete(ONE, status_code=204, response_class=Response, responses=problem_responses(401, 403, 404, 409))
def delete_column(class_id: str, column_id: str, account: ApiAccount, db: Db) -> Response:
    """Takes a column out of the gradebook. It is kept, with its marks, and can be restored."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    columns.delete_column(db, place.school_class, account, _parse_column_id(column_id))
    return Response(status_code=204)


@router.post(f"{ONE}/restore", responses=problem_responses(401, 403, 404, 409))
def restore_column(class_id: str, column_id: str, account: ApiAccount, db: Db) -> ColumnOut:
    """Puts a deleted column back, with its marks."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    return _column_out(columns.restore_column(db, place.school_class, account, _parse_column_id(column_id)))


@router.put(f"{ONE}/marks", responses=problem_responses(400, 401, 403, 404, 409, 413, 422))
def set_column_marks(class_id: str, column_id: str, body: TypedMarksIn, account: ApiAccount, db: Db) -> ColumnWithMarks:
    """Stores the marks that are sent, all or none; those of other students stay."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    entries = [_mark_entry(mark) for mark in body.marks]
    column = columns.store_column_marks(db, place.school_class, account, _parse_column_id(column_id), entries)
    return _column_with_marks(db, place.school_class, column)


def _mark_entry(mark: TypedMarkIn) -> MarkEntry:
    if mark.student is None:
        raise NotFound(NOT_A_MEMBER)
    if mark.points is not None and mark.state is not None:
        raise Invalid(POINTS_OR_STATE)
    typed = TypedMark(mark.points, None if mark.state is None else TypedState(mark.state))
    return MarkEntry(mark.student, typed, mark.comment, mark.version)


def _parse_column_id(column_id: str) -> UUID:
    return parse_uuid(column_id, columns.UNKNOWN)


def _column_out(column: ManualColumn) -> ColumnOut:
    return ColumnOut.model_validate(_column_out_values(column))


def _column_out_values(column: ManualColumn) -> dict[str, Any]:
    return {name: getattr(column, name) for name in ColumnOut.model_fields}


def _column_with_marks(db: Db, school_class: SchoolClass, column: ManualColumn) -> ColumnWithMarks:
    stored = repository.load_column_marks(db, column.id)
    marks = []
    for student in classes.load_student_records(db, school_class.id):
        row = stored.get(student.id)
        typed = NEVER_TYPED if row is None else repository.build_typed_mark(row)
        marks.append({"student": student.id, "name": student.name, **asdict(typed)})
    return ColumnWithMarks.model_validate({**_column_out_values(column), "marks": marks})
