"""Columns of a teacher's own: made, changed, published, ordered, deleted, restored; the marks typed in them.

Functions work inside the caller's transaction. Changes lock the class, so that two teachers take turns.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from uuid import UUID

from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, Invalid, NotFound
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.service import NOT_A_MEMBER, require_not_archived
from server.database import utc_now
from server.identity.models import Account
from server.marks import columns_repository as repository
from server.marks import rubrics_repository
from server.marks.means import format_number
from server.marks.models import ManualColumn, ManualMark
from server.marks.schemas import NEVER_TYPED, TypedMark
from server.marks.typed import ColumnInput, parse_mark_comment, require_points_on_scale, validate_column_fields

MAX_COLUMNS = 50
MAX_WITH_DELETED = 200
UNKNOWN = "La classe n’a pas cette colonne."
DELETED = "Cette colonne est supprimée : rétablissez-la d’abord."
TOO_MANY = f"La classe a déjà {MAX_COLUMNS} colonnes : supprimez-en une d’abord."
TOO_MANY_DELETED = f"La classe a déjà fait {MAX_WITH_DELETED} colonnes : rétablissez-en une, et renommez-la."
SCALE_BELOW = "Une note de {points} est déjà tapée : le barème ne peut pas descendre en dessous."
COLUMN_CHANGED = "Cette colonne a été modifiée entre-temps : relisez-la, puis recommencez."
MARK_CHANGED = "Entre-temps, d’autres notes ont été tapées pour : {names}. Rien n’est enregistré : relisez-les d’abord."


@dataclass(frozen=True)
class MarkEntry:
    """A mark to store for a student. `comment`: None leaves it as it is; `version`: that of the mark which the teacher
    has seen, None stores it whatever is there."""

    student: UUID
    typed: TypedMark
    comment: str | None = None
    version: int | None = None


def create_column(db: Session, school_class: SchoolClass, by: Account, fields: ColumnInput) -> ManualColumn:
    """Create a column after the others. Raise Conflict or InvalidFields."""
    _lock_open_class(db, school_class)
    fields = validate_column_fields(fields)
    columns = _require_room_for_column(db, school_class)
    if repository.count_columns_with_deleted(db, school_class.id) >= MAX_WITH_DELETED:
        raise Conflict(TOO_MANY_DELETED)
    position = 1 + max((column.position for column in columns), default=0)
    column = ManualColumn(class_id=school_class.id, created_by=by.id, position=position, **asdict(fields))
    db.add(column)
    db.flush()
    _record_column_event(db, by, AuditAction.column_made, column, {}, _audited_column_values(column))
    return column


def _lock_open_class(db: Session, school_class: SchoolClass) -> None:
    require_not_archived(school_class)
    classes.lock_class(db, school_class.id)


def _require_room_for_column(db: Session, school_class: SchoolClass) -> Sequence[ManualColumn]:
    columns = repository.list_columns(db, school_class.id)
    if len(columns) >= MAX_COLUMNS:
        raise Conflict(TOO_MANY)
    return columns


def find_column(db: Session, school_class: SchoolClass, column_id: UUID) -> ManualColumn:
    """Return a column of the class, deleted or not. Raise NotFound."""
    column = repository.find_column(db, school_class.id, column_id)
    if column is None:
        raise NotFound(UNKNOWN)
    return column


def lock_column(db: Session, school_class: SchoolClass, column_id: UUID) -> ManualColumn:
    """Return a column that is not deleted, and lock those of the class until the commit. Raise NotFound or Conflict."""
    _lock_open_class(db, school_class)
    column = find_column(db, school_class, column_id)
    db.refresh(column)
    if column.deleted_at is not None:
        raise Conflict(DELETED)
    return column


def editable_column_fields(column: ManualColumn) -> ColumnInput:
    return ColumnInput(column.title, column.out_of, column.taken_on, column.weight, column.bonus)


def change_column(
    db: Session, school_class: SchoolClass, by: Account, column_id: UUID, fields: ColumnInput
) -> ManualColumn:
    """Change a column; its marks stay. Raise NotFound, Conflict, Invalid or InvalidFields."""
    column = lock_column(db, school_class, column_id)
    fields = validate_column_fields(fields)
    highest = max((mark.points or 0.0 for mark in repository.load_column_marks(db, column.id).values()), default=0.0)
    if highest > fields.out_of:
        raise Invalid(SCALE_BELOW.format(points=format_number(highest)))
    _set_column_values(db, by, column, asdict(fields))
    return column


def set_column_published(
    db: Session, school_class: SchoolClass, by: Account, column_id: UUID, *, published: bool
) -> ManualColumn:
    """Show a column to the students, or hide it from them again. Raise NotFound or Conflict.

    The copies that are marked by its rubric get their marks when it is published.
    """
    column = lock_column(db, school_class, column_id)
    if (column.published_at is not None) is not published:
        if published:
            store_column_marks(db, school_class, by, column.id, _load_rubric_mark_entries(db, school_class, column))
        _set_column_values(db, by, column, {"published_at": utc_now() if published else None})
    return column


def _load_rubric_mark_entries(db: Session, school_class: SchoolClass, column: ManualColumn) -> Sequence[MarkEntry]:
    """Return the marks of the finished copies of present students; none for a column without a rubric."""
    rubric = rubrics_repository.find_rubric_of_column(db, column.id)
    if rubric is None:
        return []
    items = rubrics_repository.read_rubric_items(rubric)
    markings = rubrics_repository.load_rubric_markings(db, column.id)
    return [
        MarkEntry(student.id, TypedMark(points=rubrics_repository.read_rubric_scores(marking).total_over(items)))
        for student in classes.load_student_records(db, school_class.id)
        if (marking := markings.get(student.id)) is not None and marking.finished_at is not None
    ]


def require_student(db: Session, school_class: SchoolClass, student: UUID) -> None:
    """Raise NotFound for anyone but an active student of the class."""
    if not classes.load_student_records(db, school_class.id, [student]):
        raise NotFound(NOT_A_MEMBER)


def _set_column_values(db: Session, by: Account, column: ManualColumn, values: Mapping[str, object]) -> None:
    before = _audited_column_values(column)
    if all(getattr(column, name) == value for name, value in values.items()):
        return
    for name, value in values.items():
        setattr(column, name, value)
    column.version += 1
    db.flush()
    _record_column_event(db, by, AuditAction.column_changed, column, before, _audited_column_values(column))


def move_column(db: Session, school_class: SchoolClass, by: Account, column_id: UUID, place: int) -> ManualColumn:
    """Give a column this place among the others, from 0; beyond the ends, the first or the last. Raise as above."""
    column = lock_column(db, school_class, column_id)
    columns = [*repository.list_columns(db, school_class.id)]
    before = columns.index(column)
    columns.remove(column)
    columns.insert(max(0, min(place, len(columns))), column)
    for position, each in enumerate(columns, 1):
        each.position = position
    db.flush()
    moved = columns.index(column)
    if moved != before:
        _record_column_event(
            db, by, AuditAction.column_changed, column, {"position": before + 1}, {"position": moved + 1}
        )
    return column


def delete_column(db: Session, school_class: SchoolClass, by: Account, column_id: UUID) -> None:
    """Take a column out of the gradebook; its marks are stored, for `restore_column`. Raise NotFound or Conflict."""
    _lock_open_class(db, school_class)
    column = find_column(db, school_class, column_id)
    if column.deleted_at is None:
        column.deleted_at, column.version = utc_now(), column.version + 1
        db.flush()
        _record_column_event(db, by, AuditAction.column_deleted, column, _audited_column_values(column), {})


def restore_column(db: Session, school_class: SchoolClass, by: Account, column_id: UUID) -> ManualColumn:
    """Put a deleted column back, with its marks. Raise NotFound or Conflict."""
    _lock_open_class(db, school_class)
    column = find_column(db, school_class, column_id)
    if column.deleted_at is not None:
        _require_room_for_column(db, school_class)
        column.deleted_at, column.version = None, column.version + 1
        db.flush()
        _record_column_event(db, by, AuditAction.column_restored, column, {}, _audited_column_values(column))
    return column


def store_column_marks(
    db: Session, school_class: SchoolClass, by: Account, column_id: UUID, entries: Sequence[MarkEntry]
) -> ManualColumn:
    """Store marks, all or none. Raise NotFound, Conflict or Invalid.

    An entry that changes nothing is no change, whatever its version.
    """
    column = lock_column(db, school_class, column_id)
    names = {student.id: student.name for student in classes.load_student_records(db, school_class.id)}
    stored = repository.load_column_marks(db, column.id)
    changes, changed_names = [], []
    for entry in entries:
        if entry.student not in names:
            raise NotFound(NOT_A_MEMBER)
        current = stored.get(entry.student)
        seen = NEVER_TYPED if current is None else repository.build_typed_mark(current)
        comment = seen.comment if entry.comment is None else parse_mark_comment(entry.comment)
        points = None if entry.typed.points is None else require_points_on_scale(entry.typed.points, column.out_of)
        wanted = TypedMark(points, entry.typed.state, comment, seen.version)
        if wanted == seen:
            continue
        if entry.version is not None and entry.version != seen.version:
            changed_names.append(names[entry.student])
        changes.append((entry.student, current, seen, wanted))
    if changed_names:
        raise Conflict(MARK_CHANGED.format(names=", ".join(changed_names)))
    for student, current, seen, wanted in changes:
        _store_mark(db, by, column, student, current, seen, wanted)
    db.flush()
    return column


def _store_mark(
    db: Session,
    by: Account,
    column: ManualColumn,
    student: UUID,
    current: ManualMark | None,
    previous: TypedMark,
    new_mark: TypedMark,
) -> None:
    mark = current or ManualMark(column_id=column.id, account_id=student, version=0)
    mark.points, mark.comment = new_mark.points, new_mark.comment
    mark.state = None if new_mark.state is None else new_mark.state.value
    mark.by, mark.at, mark.version = by.id, utc_now(), mark.version + 1
    db.add(mark)
    audit.record_event(
        db,
        column.class_id,
        by.id,
        AuditAction.column_mark_changed,
        student=student,
        about=column.title,
        before=_audited_mark_values(previous),
        after=_audited_mark_values(new_mark),
        reason=new_mark.comment
        if new_mark.comment != previous.comment
        else "",  # erased with the student, as values are not
    )


def _audited_mark_values(mark: TypedMark) -> dict[str, object]:
    return {"points": mark.points, "state": mark.state}


def _audited_column_values(column: ManualColumn) -> dict[str, object]:
    taken_on = None if column.taken_on is None else column.taken_on.isoformat()
    return {**asdict(editable_column_fields(column)), "taken_on": taken_on, "published_at": column.published_at}


def _record_column_event(
    db: Session,
    by: Account,
    action: AuditAction,
    column: ManualColumn,
    before: Mapping[str, object],
    after: Mapping[str, object],
) -> None:
    audit.record_event(db, column.class_id, by.id, action, about=column.title, before=before, after=after)
