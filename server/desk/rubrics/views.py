"""From rubrics and the copies marked by them to what the templates show, and from their forms to rubrics and marks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.assignments.rules import is_assigned_to
from server.assignments.sitting_repository import load_sittings
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import TeamPlace, list_current_partners
from server.base.errors import NotFound
from server.classes import repository as classes
from server.classes.schemas import StudentRecord
from server.desk import repository as desk
from server.desk.assignments.views import TAB, assignment_href
from server.desk.rubrics.copies import CopyView, build_copy
from server.desk.rubrics.forms import EMPTY_ROWS, ItemRow, RubricForm, TypedCopy, stored_form
from server.desk.schemas import ClassHead
from server.desk.views import class_head
from server.marks import rubrics, rubrics_repository
from server.marks.means import format_number
from server.marks.models import ManualColumn, Rubric, RubricMarking
from server.marks.rubric_items import (
    MAX_ITEMS,
    OVERALL,
    RubricItem,
)
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.form_version import form_version_tag
from server.web.views import Reader

COPIES_A_PAGE = 50
NO_SUCH_COPY = "Cette copie n’existe pas, ou son élève n’est plus dans la classe."


@dataclass(frozen=True)
class RubricPage:
    head: ClassHead
    assignment: Assignment
    href: str
    form: RubricForm
    column: ManualColumn | None
    version: str
    may_change: bool


def build_rubric_page(
    reader: Reader, access: ClassAccess, assignment: Assignment, form: RubricForm | None = None
) -> RubricPage:
    row = rubrics_repository.find_rubric(reader.db, assignment.id)
    stored = stored_form(assignment, row)
    shown = form or stored
    empty = max(EMPTY_ROWS, 4 - len(shown.rows))
    rows = (*shown.rows, *(ItemRow() for _ in range(min(empty, MAX_ITEMS - len(shown.rows)))))
    return RubricPage(
        head=class_head(reader.course, access, TAB),
        assignment=assignment,
        href=assignment_href(assignment),
        form=replace(shown, rows=rows),
        column=None if row is None else row[1],
        version=form_version_tag(stored.texts),
        may_change=may_mark(access),
    )


def may_mark(access: ClassAccess) -> bool:
    return access.has(Right.change_marks) and access.school_class.archived_at is None


@dataclass(frozen=True)
class CopyRow:
    """A copy in the list. `name` is a number where names are hidden; `total` is empty without a mark."""

    key: str
    student: UUID
    number: int
    name: str
    sent: bool
    marking: RubricMarking | None
    total: str

    @property
    def finished(self) -> bool:
        return self.marking is not None and self.marking.finished_at is not None


@dataclass(frozen=True)
class CopiesPage:
    """The copies of an assignment, those to which something was sent first. `next_key`: the next one to mark."""

    head: ClassHead
    assignment: Assignment
    href: str
    rubric: Rubric
    column: ManualColumn
    rows: tuple[CopyRow, ...]
    shown: tuple[CopyRow, ...]
    search: str
    number: int
    more: bool
    next_key: str
    may_change: bool
    hides_names: bool

    @property
    def finished(self) -> int:
        return sum(row.finished for row in self.rows)

    @property
    def unfinished_sent(self) -> int:
        return sum(row.sent and not row.finished for row in self.rows)


def hides_names(rubric: Rubric, column: ManualColumn) -> bool:
    return rubric.anonymous and column.published_at is None


def list_copies(
    db: Session, access: ClassAccess, assignment: Assignment, rubric: Rubric, column: ManualColumn
) -> tuple[CopyRow, ...]:
    """List the copies by name, those to which something was sent first; in an order that tells no name while names are
    hidden."""
    markings = rubrics_repository.load_rubric_markings(db, rubric.column_id)
    senders = desk.load_senders(db, access.school_class.id, assignment.id)
    items = rubrics_repository.read_rubric_items(rubric)
    everyone = classes.load_student_records(db, access.school_class.id)
    sittings = load_sittings(db, [assignment.id])
    places = load_places_of_team_assignments(db, [assignment]).get(assignment.id, ())
    present = {s.id: s for s in everyone if is_assigned_to(assignment, s.groups) or (assignment.id, s.id) in sittings}
    copies = {_copy_members(places, student, present, rubric) for student in present.values()}
    hidden, places_by_name = hides_names(rubric, column), {student: place for place, student in enumerate(present)}

    def order(members: tuple[StudentRecord, ...]) -> tuple[bool, int, str]:
        sent = not senders.isdisjoint(member.id for member in members)
        by_name = min(places_by_name[member.id] for member in members)
        return not sent, 0 if hidden else by_name, rubrics.anonymous_copy_key(rubric, members[0].id)

    ordered = sorted(copies, key=order)
    return tuple(
        _copy_row(
            rubric,
            items,
            members,
            number,
            markings.get(members[0].id),
            not senders.isdisjoint(member.id for member in members),
            hidden=hidden,
        )
        for number, members in enumerate(ordered, 1)
    )


def _copy_members(
    places: Sequence[TeamPlace], student: StudentRecord, present: Mapping[UUID, StudentRecord], rubric: Rubric
) -> tuple[StudentRecord, ...]:
    """Return those whose copy it is, the same ones in the same order for each of them."""
    partners = (
        present[each.account_id] for each in list_current_partners(places, student.id) if each.account_id in present
    )
    return tuple(sorted((student, *partners), key=lambda member: rubrics.anonymous_copy_key(rubric, member.id)))


def _copy_row(
    rubric: Rubric,
    items: Sequence[RubricItem],
    members: Sequence[StudentRecord],
    number: int,
    marking: RubricMarking | None,
    sent: bool,
    *,
    hidden: bool,
) -> CopyRow:
    total = ""
    if marking is not None:
        total = format_number(rubrics_repository.read_rubric_scores(marking).total_over(items))
    name = f"Copie {number}" if hidden else " et ".join(member.name for member in members)
    student = members[0]
    return CopyRow(rubrics.anonymous_copy_key(rubric, student.id), student.id, number, name, sent, marking, total)


def find_copy(rows: Sequence[CopyRow], key: str) -> CopyRow:
    """Return the copy of this name. Raise NotFound."""
    for row in rows:
        if row.key == key:
            return row
    raise NotFound(NO_SUCH_COPY)


def next_copy(rows: Sequence[CopyRow], after: str = "") -> str:
    """Return the name of the next copy that is not finished, something being sent to it; empty when there is none."""
    start = next((index for index, row in enumerate(rows, 1) if row.key == after), 0)
    for row in (*rows[start:], *rows[:start]):
        if row.sent and not row.finished and row.key != after:
            return row.key
    return ""


def build_copies_page(
    reader: Reader, access: ClassAccess, assignment: Assignment, search: str = "", number: int = 1
) -> CopiesPage:
    """Build page `number` (from 1) of the copies whose name contains `search`. Raise NotFound without a rubric."""
    rubric, column = rubrics.require_rubric(reader.db, assignment)
    rows = list_copies(reader.db, access, assignment, rubric, column)
    wanted = search.strip().casefold()
    matching = [row for row in rows if wanted in row.name.casefold()]
    first = (number - 1) * COPIES_A_PAGE
    return CopiesPage(
        head=class_head(reader.course, access, TAB),
        assignment=assignment,
        href=assignment_href(assignment),
        rubric=rubric,
        column=column,
        rows=rows,
        shown=tuple(matching[first : first + COPIES_A_PAGE]),
        search=search,
        number=number,
        more=first + COPIES_A_PAGE < len(matching),
        next_key=next_copy(rows),
        may_change=may_mark(access),
        hides_names=hides_names(rubric, column),
    )


@dataclass(frozen=True)
class CriterionView:
    """A criterion of the form: what is typed for it; `picked` is the index of its words, -1 for none."""

    item: RubricItem
    points: str
    picked: int
    remark: str
    problem: str = ""


@dataclass(frozen=True)
class MarkingPage:
    head: ClassHead
    assignment: Assignment
    href: str
    rubric: Rubric
    column: ManualColumn
    row: CopyRow
    position: int
    count: int
    copy: CopyView
    criteria: tuple[CriterionView, ...]
    overall: str
    version: int
    problem: str
    previous_key: str
    next_key: str
    may_change: bool
    finished: int


def build_marking_page(
    reader: Reader, access: ClassAccess, assignment: Assignment, key: str, typed: TypedCopy | None = None
) -> MarkingPage:
    """Build the page on which a copy is marked. Raise NotFound."""
    rubric, column = rubrics.require_rubric(reader.db, assignment)
    rows = list_copies(reader.db, access, assignment, rubric, column)
    row = find_copy(rows, key)
    items = rubrics_repository.read_rubric_items(rubric)
    shown = typed or _stored_copy(row.marking)
    keys = [each.key for each in rows if each.sent or each.key == key]
    place = keys.index(key)
    return MarkingPage(
        head=class_head(reader.course, access, TAB),
        assignment=assignment,
        href=assignment_href(assignment),
        rubric=rubric,
        column=column,
        row=row,
        position=place + 1,
        count=len(keys),
        copy=build_copy(
            reader, access, assignment, row.student, row.name, with_threads=not hides_names(rubric, column)
        ),
        criteria=tuple(_criterion_view(item, shown) for item in items),
        overall=shown.remarks.get(OVERALL, ""),
        version=0 if row.marking is None else row.marking.version,
        problem=shown.problems.get(OVERALL, ""),
        previous_key=keys[place - 1] if place else "",
        next_key=keys[place + 1] if place + 1 < len(keys) else "",
        may_change=may_mark(access),
        finished=sum(each.finished for each in rows),
    )


def _stored_copy(marking: RubricMarking | None) -> TypedCopy:
    if marking is None:
        return TypedCopy({}, {})
    marks = rubrics_repository.read_rubric_scores(marking)
    return TypedCopy({item: format_number(points) for item, points in marks.points.items()}, marks.remarks)


def _criterion_view(item: RubricItem, typed: TypedCopy) -> CriterionView:
    text = typed.points.get(item.id, "").strip()
    by_words = {format_number(level.points): index for index, level in reversed([*enumerate(item.levels)])}
    picked = by_words.get(text.replace(".", ","), -1)
    return CriterionView(
        item=item,
        points="" if picked >= 0 else text,
        picked=picked,
        remark=typed.remarks.get(item.id, ""),
        problem=typed.problems.get(item.id, ""),
    )
