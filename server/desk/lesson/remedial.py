"""From a line of « Après la séance » to its doing: an exercise for these students, an assignment re-opened for them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from typing import Annotated
from urllib.parse import urlencode
from uuid import UUID

from fastapi import APIRouter, Form, Query, Request
from fastapi.responses import Response
from sqlalchemy.orm import Session

from server.assignments import editing, remedial
from server.base import school_time
from server.base.errors import Invalid, InvalidFields, NotFound
from server.classes import repository as classes
from server.classes.schemas import ActiveStudent
from server.course import Course
from server.course.dependencies import CourseOf
from server.course.practice import practised_objectives
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

PATH = "/classes/{class_id}/reprise"
MAX_STUDENTS = 60
DAYS, HOUR = 7, 18
Chosen = Annotated[list[UUID] | None, Query(max_length=MAX_STUDENTS)]
Ticked = Annotated[list[UUID] | None, Form(max_length=400)]


def remedial_href(class_href: str, exercise: str, students: Collection[UUID]) -> str:
    """Return the address of the page for these students; empty where they are too many for an address."""
    if not 0 < len(students) <= MAX_STUDENTS:
        return ""
    query = [("exercice", exercise), *(("eleve", str(student)) for student in students)]
    return f"{class_href}/reprise?{urlencode(query)}"


@dataclass(frozen=True)
class RemedialForms:
    """What is chosen in the forms, and what is wrong with it by field; `action`: the form that was sent."""

    students: Collection[UUID]
    exercise: str
    until: str
    assignment: str = ""
    action: str = ""
    problems: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class RemedialPage:
    """`exercise`, `about`: id and title of what was not solved; `exercises`: those of the same
    objectives first; `assignments` may be re-opened."""

    head: ClassHead
    exercise: str
    about: str
    students: Sequence[ActiveStudent]
    exercises: tuple[tuple[str, str], ...]
    assignments: tuple[tuple[str, str], ...]
    forms: RemedialForms
    zone: str


@router.get(PATH)
def show_remedial(
    request: Request, class_id: str, reader: CurrentReader, exercice: ShortQuery = "", eleve: Chosen = None
) -> Response:
    """`eleve`: the students of the line; `exercice`: the exercise that they do not solve."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.manage_assignments, class_id)
    forms = RemedialForms(eleve or (), "", school_time.format_field(_default_date(utc_now())))
    view = _build_page(reader.db, reader.course, access, exercice, forms)
    return render_page(request, "classes/remedial.html", reader.account, page=view)


def _default_date(now: datetime) -> datetime:
    local = school_time.to_local(school_time.shift_days(now, DAYS))
    return local.replace(hour=HOUR, minute=0, second=0, microsecond=0)


def _build_page(db: Session, course: Course, access: ClassAccess, exercise: str, forms: RemedialForms) -> RemedialPage:
    school_class = access.school_class
    titles = editing.load_assignable_titles(db, course, school_class)
    related = _related_exercises(course, exercise)
    ordered = dict.fromkeys([*related, *([exercise] if exercise in titles else ()), *titles])
    return RemedialPage(
        head=class_head(course, access, "/devoirs"),
        exercise=exercise,
        about=titles.get(exercise, ""),
        students=classes.load_active_students(db, school_class.id),
        exercises=tuple((name, titles[name]) for name in ordered if name in titles),
        assignments=tuple(
            (str(assignment.id), assignment.title)
            for assignment in remedial.list_reopenable_assignments(db, school_class, utc_now())
        ),
        forms=forms,
        zone=school_time.time_zone_name(),
    )


def _related_exercises(course: Course, exercise: str) -> Sequence[str]:
    """Return the other exercises that practise an objective of this one, in the order of the objectives."""
    known = course.exercises.get(exercise)
    module = None if known is None else course.modules.get(known.module)
    if known is None or module is None:
        return []
    slugs = [
        slug
        for objective in practised_objectives(module)
        if known.slug in objective.exercises
        for slug in objective.exercises
        if slug != known.slug
    ]
    return list(dict.fromkeys(f"{module.slug}/{slug}" for slug in slugs))


@router.post(PATH)
def give_or_reopen(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, action: Field = "",
    exercice: Field = "", devoir: Field = "", date: Field = "", sur: Field = "", eleve: Ticked = None,
) -> Response:  # fmt: skip
    """`sur`: the exercise that the students did not solve."""
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    school_class, now, students = access.school_class, utc_now(), tuple(eleve or ())
    if action not in {"donner", "rouvrir"}:
        raise NotFound(UNKNOWN_ACTION)
    try:
        until = _parse_date(date)
        if action == "donner":
            rights.require_right(db, account, Right.manage_roster, class_id)
            name = f"Reprise {school_time.to_local(now):%d/%m}"
            made = remedial.assign_exercise_to_students(
                db, course, school_class, account.id, students, exercice, name, until, now
            )
            return redirect(f"{class_href(school_class)}/devoirs/{made.id}")
        assignment = editing.find_assignment(db, school_class, devoir, to_change=True)
        remedial.reopen_for_students(db, school_class, account.id, assignment, students, until, now)
        return redirect(f"{class_href(school_class)}/devoirs/{assignment.id}/amenagements")
    except InvalidFields as refused:
        roll_back_then_read(db)
        forms = RemedialForms(students, exercice, date, devoir, action, refused.problems)
        view = _build_page(db, course, access, sur, forms)
        return render_page(request, "classes/remedial.html", account, status=422, page=view)


def _parse_date(text: str) -> datetime | None:
    try:
        return school_time.parse_field(text, "Date limite")
    except Invalid as refused:
        raise InvalidFields({"due_at": refused.detail}) from None
