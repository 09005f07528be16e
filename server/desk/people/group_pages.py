"""The page of the groups of a class: make them from a list or at random, rename and dissolve them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from random import SystemRandom
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response
from sqlalchemy.orm import Session

from server.assignments import groups
from server.assignments.groups import GroupUsage
from server.base import school_time
from server.base.errors import InvalidFields, NotFound
from server.classes import repository as classes
from server.classes.schemas import Member
from server.course import Course
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read, utc_now
from server.database.dependencies import Db
from server.desk.requests import ShortQuery
from server.desk.schemas import ClassHead
from server.desk.views import class_head, class_href
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

PATH = "/classes/{class_id}/groupes"
Chosen = Annotated[list[UUID] | None, Query(max_length=400)]


@dataclass(frozen=True)
class GroupRow:
    name: str
    students: tuple[str, ...]
    use: GroupUsage


@dataclass(frozen=True)
class GroupForms:
    """What was typed in a form (`action`), and what is wrong with it by field; `label`: the group that it is about."""

    action: str = ""
    label: str = ""
    name: str = ""
    names: str = ""
    count: str = ""
    only_present: bool = False
    problems: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class GroupsPage:
    head: ClassHead
    rows: tuple[GroupRow, ...]
    students: int
    present: int
    without_group: int
    forms: GroupForms
    may_change: bool
    may_assign: bool


@router.get(PATH)
def show_groups(
    request: Request, class_id: str, reader: CurrentReader, eleve: Chosen = None, nom: ShortQuery = ""
) -> Response:
    """`eleve`: students with whose names the form of a new group is filled."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    members = classes.load_members(reader.db, access.school_class.id)
    chosen = [_member_line(member) for member in members if member.id in (eleve or ()) and member.is_active_student]
    forms = GroupForms(action="liste", name=nom, names="\n".join(chosen)) if chosen else GroupForms()
    view = _build_page(reader.db, reader.course, access, members, forms)
    return render_page(request, "classes/class_groups.html", reader.account, page=view)


def _member_line(member: Member) -> str:
    """Return the name, or the login where namesakes are told apart by it."""
    is_ambiguous = member.name != member.plain_name and member.account.login
    return member.account.login or "" if is_ambiguous else member.plain_name


def _build_page(
    db: Session, course: Course, access: ClassAccess, members: Sequence[Member], forms: GroupForms
) -> GroupsPage:
    students = [member for member in members if member.is_active_student]
    uses = groups.load_group_usage(db, access.school_class)
    labels = sorted({label for student in students for label in student.groups} | uses.keys(), key=str.casefold)
    return GroupsPage(
        head=class_head(course, access, "/eleves"),
        rows=tuple(
            GroupRow(
                label,
                tuple(student.name for student in students if label in student.groups),
                uses.get(label, GroupUsage()),
            )
            for label in labels
        ),
        students=len(students),
        present=len(_present_students(students)),
        without_group=sum(not student.groups for student in students),
        forms=forms,
        may_change=access.has(Right.manage_roster) and access.school_class.archived_at is None,
        may_assign=access.has(Right.manage_assignments) and access.school_class.archived_at is None,
    )


def _present_students(students: Sequence[Member]) -> Sequence[Member]:
    """Return the students who were seen today, on the school's clock."""
    today = school_time.to_local(utc_now()).date()
    seen = ((student, student.membership.last_seen_at) for student in students)
    return [student for student, at in seen if at is not None and school_time.to_local(at).date() == today]


@router.post(PATH)
def change_groups(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, action: Field = "",
    groupe: Field = "", nom: Field = "", noms: Field = "", combien: Field = "", presents: Field = "",
) -> Response:  # fmt: skip
    access = rights.require_right(db, account, Right.manage_roster, class_id)
    school_class = access.school_class
    members = classes.load_members(db, school_class.id)
    try:
        if action == "liste":
            groups.create_group(db, school_class, account.id, nom, groups.find_named_students(members, noms))
        elif action == "hasard":
            students = [member for member in members if member.is_active_student]
            dealt = [student.id for student in (_present_students(students) if presents else students)]
            count = int(combien) if combien.isdecimal() and len(combien) < 4 else 0
            groups.create_random_groups(db, school_class, account.id, nom, count, dealt, SystemRandom())
        elif action == "renommer":
            groups.rename_group(db, school_class, account.id, groupe, nom)
        elif action == "dissoudre":
            groups.delete_group(db, school_class, account.id, groupe)
        else:
            raise NotFound(UNKNOWN_ACTION)
    except InvalidFields as refused:
        roll_back_then_read(db)
        forms = GroupForms(action, groupe, nom, noms, combien, bool(presents), refused.problems)
        members = classes.load_members(db, school_class.id)
        view = _build_page(db, course, access, members, forms)
        return render_page(request, "classes/class_groups.html", account, status=422, page=view)
    return redirect(f"{class_href(school_class)}/groupes")
