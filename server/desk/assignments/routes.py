"""Pages by which a teacher gives assignments: their list, one of them, the form."""

from __future__ import annotations

from dataclasses import replace

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.assignments import editing
from server.assignments.models import Assignment
from server.assignments.schemas import AssignmentInput, validate_assignment
from server.base.errors import InvalidFields
from server.classes.service import require_not_archived
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read
from server.database.dependencies import Db
from server.desk import views
from server.desk.assignments import exam_papers
from server.desk.assignments import forms as assignment_forms
from server.desk.assignments import views as assignment_views
from server.desk.assignments.schemas import AssignmentFormPage
from server.desk.requests import ShortQuery
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.form_version import VERSION_FIELD, form_version_tag, require_unchanged_values
from server.web.forms import FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

SUBJECT = "Ce devoir"
ASSIGNMENTS_PATH, ASSIGNMENT_PATH = "/classes/{class_id}/devoirs", "/classes/{class_id}/devoirs/{aid}"


@router.get(ASSIGNMENTS_PATH)
def list_assignments(request: Request, class_id: str, reader: CurrentReader) -> Response:
    """A student has theirs on the class's page."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_assignments, class_id)
    if not access.has(Right.see_students):
        return redirect(views.class_href(access.school_class))
    view = assignment_views.build_assignments_page(reader.db, reader.course, access)
    return render_page(request, "classes/assignments.html", reader.account, page=view)


@router.get(f"{ASSIGNMENTS_PATH}/nouveau")
def show_new_form(
    request: Request,
    class_id: str,
    reader: CurrentReader,
    sujet: ShortQuery = "",
    groupe: ShortQuery = "",
    exercice: ShortQuery = "",
) -> Response:
    """`sujet` names a paper of the course, `groupe` a group, `exercice` an exercise: the form is filled with them."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.manage_assignments, class_id)
    require_not_archived(access.school_class)
    values = exam_papers.paper_form_values(reader.course, access.school_class.module, sujet)
    if groupe in editing.load_groups(reader.db, access.school_class):
        values = replace(values, audience="groupes", groups=(groupe,))
    if exercice in editing.load_assignable_titles(reader.db, reader.course, access.school_class):
        values = replace(values, weights={**values.weights, exercice: "1"})
    view = assignment_views.build_form_page(reader.db, reader.course, access, values)
    return render_page(request, "classes/assignment_form.html", reader.account, page=view)


@router.post(ASSIGNMENTS_PATH)
def create_assignment(
    request: Request, class_id: str, account: SignedIn, db: Db, course: CourseOf, fields: FormFields
) -> Response:
    """With `apercu`, only draws what the form says of lateness."""
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    values = assignment_forms.submitted_assignment_values(fields)
    drawn: AssignmentInput | None = None
    try:
        wanted = assignment_forms.parse_assignment(fields, None)
        if not fields.get("apercu"):
            made = editing.create_assignment(db, course, access.school_class, account.id, wanted)
            return redirect(assignment_views.assignment_href(made))
        drawn = validate_assignment(
            wanted,
            editing.load_assignable_titles(db, course, access.school_class),
            editing.load_groups(db, access.school_class),
        )
        problems = {}
    except InvalidFields as refused:
        problems = refused.problems
    roll_back_then_read(db)
    view = assignment_views.build_form_page(db, course, access, values, problems=problems, drawn=drawn)
    return _render_form(request, account, view)


def _render_form(request: Request, account: SignedIn, view: AssignmentFormPage) -> HTMLResponse:
    return render_page(
        request, "classes/assignment_form.html", account, status=422 if view.problems else 200, page=view
    )


@router.get(ASSIGNMENT_PATH)
def show_assignment(request: Request, class_id: str, aid: str, reader: CurrentReader) -> Response:
    """A student has it on the class's page."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_assignments, class_id)
    found = editing.find_assignment(reader.db, access.school_class, aid)
    if not access.has(Right.see_students):
        return redirect(f"{views.class_href(access.school_class)}#devoir-{found.id}")
    view = assignment_views.build_assignment_page(reader.db, reader.course, access, found)
    return render_page(request, "classes/assignment.html", reader.account, page=view)


@router.get(f"{ASSIGNMENT_PATH}/modifier")
def show_edit_form(request: Request, class_id: str, aid: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.manage_assignments, class_id)
    require_not_archived(access.school_class)
    found = editing.find_assignment(reader.db, access.school_class, aid)
    wanted = editing.load_editable_fields(reader.db, found)
    values = assignment_forms.stored_assignment_values(wanted)
    version = form_version_tag(assignment_forms.assignment_texts(values))
    view = assignment_views.build_form_page(
        reader.db, reader.course, access, values, assignment=found, drawn=wanted, version=version
    )
    return render_page(request, "classes/assignment_form.html", reader.account, page=view)


@router.post(f"{ASSIGNMENT_PATH}/modifier")
def update_assignment(
    request: Request, class_id: str, aid: str, account: SignedIn, db: Db, course: CourseOf, fields: FormFields
) -> Response:
    """With `apercu`, only draws what the form says of lateness."""
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    found = editing.find_assignment(db, access.school_class, aid, to_change=True)
    values = assignment_forms.submitted_assignment_values(fields)
    drawn: AssignmentInput | None = None
    try:
        before = editing.load_editable_fields(db, found)
        wanted = assignment_forms.parse_assignment(fields, before)
        if not fields.get("apercu"):
            stored = assignment_forms.assignment_texts(assignment_forms.stored_assignment_values(before))
            require_unchanged_values(fields, account, SUBJECT, stored, assignment_forms.assignment_texts(values))
            editing.update_assignment(db, course, access.school_class, account.id, found, wanted)
            return redirect(assignment_views.assignment_href(found))
        known = {each.exercise: each.exercise for each in before.exercises}
        labels = {*editing.load_groups(db, access.school_class), *before.groups}
        known |= dict(editing.load_assignable_titles(db, course, access.school_class))
        drawn = validate_assignment(wanted, known, labels)
        problems = {}
    except InvalidFields as refused:
        problems = refused.problems
    roll_back_then_read(db)
    version = assignment_forms.field_text(fields, VERSION_FIELD)
    view = assignment_views.build_form_page(
        db, course, access, values, assignment=found, problems=problems, drawn=drawn, version=version
    )
    return _render_form(request, account, view)


@router.post(f"{ASSIGNMENT_PATH}/retablir")
def restore_assignment(class_id: str, aid: str, account: SignedIn, db: Db) -> Response:
    """Undoes a deletion."""
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    restored = editing.restore_assignment(db, access.school_class, account.id, aid)
    return redirect(assignment_views.assignment_href(restored))


@router.post(f"{ASSIGNMENT_PATH}/supprimer")
def delete_assignment(class_id: str, aid: str, account: SignedIn, db: Db) -> Response:
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    found: Assignment = editing.find_assignment(db, access.school_class, aid, to_change=True)
    editing.delete_assignment(db, access.school_class, account.id, found)
    return redirect(f"{views.class_href(access.school_class)}/devoirs")
