"""Marking by hand: the rubric of an assignment, drafts of copies, and finished ones. Functions work inside the caller's
transaction.

A rubric is that of a manual column: its marks join the gradebook when the column is published, all together, and count
there as those of any column. Once it is published, a copy that is marked again changes its mark at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import sha256
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import list_current_partners
from server.base.errors import Conflict, Invalid, NotFound
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.database import utc_now
from server.identity.models import Account
from server.marks import columns
from server.marks import rubrics_repository as repository
from server.marks.columns import MarkEntry
from server.marks.models import ManualColumn, Rubric, RubricMarking
from server.marks.rubric_items import (
    MISSING_POINTS,
    RubricInput,
    RubricItem,
    RubricScores,
    sum_item_points,
    validate_rubric,
)
from server.marks.schemas import TypedMark
from server.marks.typed import ColumnInput

NO_RUBRIC = "Ce devoir n’a pas encore de barème."
ITEM_IN_USE = (
    "« {title} » a déjà des points dans {count} copie(s) : gardez ce critère, avec au moins {most} point(s), ou "
    "reprenez d’abord ces copies. Rien n’est enregistré."
)
MARKED_MEANWHILE = "Cette copie a été notée ailleurs depuis que cette page est ouverte. Votre saisie n’est pas perdue."
KEY_DIGITS = 12


def anonymous_copy_key(rubric: Rubric, student: UUID) -> str:
    """Return the name of a copy in addresses, which tells nobody's name; copies whose names are hidden stand by it."""
    return sha256(rubric.column_id.bytes + student.bytes).hexdigest()[:KEY_DIGITS]


def require_rubric(db: Session, assignment: Assignment) -> tuple[Rubric, ManualColumn]:
    """Return the rubric of an assignment, with its column. Raise NotFound."""
    row = repository.find_rubric(db, assignment.id)
    if row is None:
        raise NotFound(NO_RUBRIC)
    return row


def save_rubric(
    db: Session, school_class: SchoolClass, by: Account, assignment: Assignment, fields: RubricInput
) -> Rubric:
    """Make or change the rubric of an assignment, with its column. Raise Conflict, Invalid or InvalidFields."""
    fields = validate_rubric(fields)
    column_fields = ColumnInput(fields.title, sum_item_points(fields.items), weight=fields.weight)
    items = [item.to_json() for item in fields.items]
    row = repository.find_rubric(db, assignment.id)
    if row is None:
        column = columns.create_column(db, school_class, by, column_fields)
        rubric = Rubric(
            column_id=column.id, assignment_id=assignment.id, items=items, anonymous=fields.anonymous, version=1
        )
        db.add(rubric)
    else:
        rubric, column = row
        columns.lock_column(db, school_class, column.id)
        _require_used_items_remain(db, rubric, fields.items)
        kept = columns.editable_column_fields(column)
        fitted = ColumnInput(fields.title, column_fields.out_of, kept.taken_on, fields.weight, kept.bonus)
        columns.change_column(db, school_class, by, column.id, fitted)
        if (rubric.items, rubric.anonymous) != (items, fields.anonymous):
            rubric.items, rubric.anonymous, rubric.version = items, fields.anonymous, rubric.version + 1
    db.flush()
    return rubric


def _require_used_items_remain(db: Session, rubric: Rubric, new_items: Sequence[RubricItem]) -> None:
    scales = {item.id: item.points for item in new_items}
    markings = repository.load_rubric_markings(db, rubric.column_id).values()
    for item in repository.read_rubric_items(rubric):
        given = [marking.points[item.id] for marking in markings if item.id in marking.points]
        if given and max(given) > scales.get(item.id, -1.0):
            raise Invalid(ITEM_IN_USE.format(title=item.title, count=len(given), most=f"{max(given):g}"))


def save_rubric_marking(
    db: Session,
    school_class: SchoolClass,
    by: Account,
    assignment: Assignment,
    student: UUID,
    marks: RubricScores,
    *,
    finish: bool,
    version: int | None = None,
) -> RubricMarking:
    """Store what a copy is given, as a draft, or with `finish` as its marking, for all who hand in with the student.

    A finished copy is never a draft again. `version` is that of the marking which the teacher has seen, 0 for none;
    None stores it whatever is there. Raise NotFound, Conflict, or Invalid where points are missing at the end.
    """
    rubric, column = require_rubric(db, assignment)
    columns.lock_column(db, school_class, column.id)
    columns.require_student(db, school_class, student)
    items = repository.read_rubric_items(rubric)
    marking = repository.find_rubric_marking(db, rubric.column_id, student)
    if marking is not None:
        db.refresh(marking)
    current = 0 if marking is None else marking.version
    if marking is not None and repository.read_rubric_scores(marking) == marks and (not finish or marking.finished_at):
        return marking
    if version is not None and version != current:
        raise Conflict(MARKED_MEANWHILE)
    finish = finish or (marking is not None and marking.finished_at is not None)
    missing = marks.titles_without_points(items)
    if finish and missing:
        raise Invalid(MISSING_POINTS.format(titles=", ".join(missing)))
    marking = marking or RubricMarking(column_id=rubric.column_id, account_id=student)
    members = [student, *_load_teammates(db, school_class, assignment, student)]
    for member in members:
        own = marking if member == student else repository.find_rubric_marking(db, rubric.column_id, member)
        own = own or RubricMarking(column_id=rubric.column_id, account_id=member)
        own.points, own.remarks = dict(marks.points), dict(marks.remarks)
        own.by, own.at, own.version = by.id, utc_now(), (own.version or 0) + 1
        if finish:
            own.finished_at = own.finished_at or own.at
        db.add(own)
    db.flush()
    if finish and column.published_at is not None:
        entries = [MarkEntry(member, TypedMark(points=marks.total_over(items))) for member in members]
        columns.store_column_marks(db, school_class, by, column.id, entries)
    return marking


def _load_teammates(db: Session, school_class: SchoolClass, assignment: Assignment, student: UUID) -> Sequence[UUID]:
    """Return the active students who hand in with this one."""
    places = load_places_of_team_assignments(db, [assignment]).get(assignment.id, ())
    partners = [partner.account_id for partner in list_current_partners(places, student)]
    return [each.id for each in classes.load_student_records(db, school_class.id, partners)] if partners else []
