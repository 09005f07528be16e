"""Pages for marking by hand: the rubric of an assignment, its copies, one copy; a student's copy, to read and print."""

from __future__ import annotations

from dataclasses import replace
from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, JSONResponse, Response

from server.assignments import editing
from server.base.errors import Conflict, Invalid, InvalidFields, NotFound
from server.classes import repository as classes
from server.classes.service import NOT_A_MEMBER
from server.database import roll_back_then_read
from server.desk.requests import ShortQuery
from server.desk.rubrics import forms, views
from server.desk.rubrics.copies import build_copy
from server.desk.views import class_head
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.marks import columns, rubrics, rubrics_repository
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader, PageNumber
from server.web.form_identity import resendable_text_fields
from server.web.form_version import FormVersionChanged, require_unchanged_values
from server.web.forms import UNKNOWN_ACTION, Field, FormFields, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import Reader
from server.web.words import format_iso_time

router = APIRouter(include_in_schema=False)

ASSIGNMENT = "/classes/{class_id}/devoirs/{aid}"
SUBJECT = "Ce barème"
SAVE_MINE = "Enregistrer ma version"


@router.get(f"{ASSIGNMENT}/bareme")
def show_rubric(request: Request, class_id: str, aid: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    view = views.build_rubric_page(reader, access, assignment)
    return render_page(request, "classes/rubric.html", reader.account, page=view)


@router.post(f"{ASSIGNMENT}/bareme")
def save_rubric(
    request: Request, class_id: str, aid: str, account: SignedIn, reader: CurrentReader, fields: FormFields
) -> Response:
    """Make or change the rubric, or with `lignes` only draw more rows."""
    access = rights.require_right(reader.db, account, Right.change_marks, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    form = forms.read_form(fields)
    if fields.get("action") == "lignes":
        roll_back_then_read(reader.db)
        view = views.build_rubric_page(reader, access, assignment, form)
        return render_page(request, "classes/rubric.html", account, page=view)
    wanted, form = forms.parse_form(form)
    if wanted is not None:
        stored = forms.stored_form(assignment, rubrics_repository.find_rubric(reader.db, assignment.id))
        require_unchanged_values(fields, account, SUBJECT, stored.texts, form.texts)
        try:
            rubrics.save_rubric(reader.db, access.school_class, account, assignment, wanted)
            return redirect(f"/classes/{class_id}/devoirs/{aid}/noter")
        except Invalid as refused:
            problems = refused.problems if isinstance(refused, InvalidFields) else {"": refused.detail}
            form = replace(form, problems=problems)
    roll_back_then_read(reader.db)
    view = views.build_rubric_page(reader, access, assignment, form)
    return render_page(request, "classes/rubric.html", account, status=422, page=view)


@router.get(f"{ASSIGNMENT}/noter")
def list_copies(
    request: Request, class_id: str, aid: str, reader: CurrentReader, q: ShortQuery = "", number: PageNumber = 1
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    if rubrics_repository.find_rubric(reader.db, assignment.id) is None:
        return redirect(f"/classes/{class_id}/devoirs/{aid}/bareme")
    view = views.build_copies_page(reader, access, assignment, q, number)
    return render_page(request, "classes/rubric_copies.html", reader.account, page=view)


@router.post(f"{ASSIGNMENT}/noter")
def change_publication(
    class_id: str, aid: str, account: SignedIn, reader: CurrentReader, action: Field = ""
) -> Response:
    """Publish the marks of all finished copies together, or hide them again."""
    access = rights.require_right(reader.db, account, Right.change_marks, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    if action not in {"publier", "cacher"}:
        raise NotFound(UNKNOWN_ACTION)
    _, column = rubrics.require_rubric(reader.db, assignment)
    columns.set_column_published(reader.db, access.school_class, account, column.id, published=action == "publier")
    return redirect(f"/classes/{class_id}/devoirs/{aid}/noter")


@router.get(f"{ASSIGNMENT}/noter/{{copy}}")
def show_marking(request: Request, class_id: str, aid: str, copy: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    return _render_marking(request, reader, reader.account, views.build_marking_page(reader, access, assignment, copy))


def _render_marking(
    request: Request, reader: Reader, account: Account, view: views.MarkingPage, status: int = 200
) -> HTMLResponse:
    return render_page(request, "classes/rubric_copy.html", account, status=status, page=view)


@router.post(f"{ASSIGNMENT}/noter/{{copy}}")
def mark_copy(
    request: Request,
    class_id: str,
    aid: str,
    copy: str,
    account: SignedIn,
    reader: CurrentReader,
    fields: FormFields,
    action: Field = "brouillon",
) -> Response:
    """Save a draft (a script is told when), or finish the copy and go on to the next one."""
    access = rights.require_right(reader.db, account, Right.change_marks, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    if action not in {"brouillon", "terminer"}:
        raise NotFound(UNKNOWN_ACTION)
    rubric, column = rubrics.require_rubric(reader.db, assignment)
    rows = views.list_copies(reader.db, access, assignment, rubric, column)
    row = views.find_copy(rows, copy)
    items = rubrics_repository.read_rubric_items(rubric)
    typed = forms.read_copy(fields, items)
    seen = str(fields.get("version", ""))
    by_script = "application/json" in request.headers.get("accept", "")
    try:
        marks = forms.parse_copy(items, typed)
        marking = rubrics.save_rubric_marking(
            reader.db,
            access.school_class,
            account,
            assignment,
            row.student,
            marks,
            finish=action == "terminer",
            version=int(seen) if seen.isdecimal() and len(seen) < 10 else None,
        )
    except Invalid as refused:
        if by_script:
            raise
        roll_back_then_read(reader.db)
        view = views.build_marking_page(reader, access, assignment, copy, forms.with_refusal(typed, refused))
        return _render_marking(request, reader, account, view, int(refused.status))
    except Conflict as refused:
        if refused.detail != rubrics.MARKED_MEANWHILE:
            raise
        version = 0 if row.marking is None else row.marking.version
        raise FormVersionChanged(
            refused.detail,
            resendable_text_fields(fields),
            account=account,
            button=SAVE_MINE,
            replacements={"version": str(version)},
        ) from refused
    if by_script:
        return JSONResponse({"saved_at": format_iso_time(marking.at), "version": str(marking.version)})
    listing = f"/classes/{class_id}/devoirs/{aid}/noter"
    if action == "brouillon":
        return redirect(f"{listing}/{copy}")
    following = views.next_copy(rows, copy)
    return redirect(f"{listing}/{following}" if following else listing)


@router.get(f"{ASSIGNMENT}/copies/{{student}}")
def show_copy(request: Request, class_id: str, aid: str, student: UUID, reader: CurrentReader) -> Response:
    """The copy of a student, for who teaches them."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    records = classes.load_student_records(reader.db, access.school_class.id, [student])
    if not records:
        raise NotFound(NOT_A_MEMBER)
    view = build_copy(reader, access, assignment, student, records[0].name)
    head = class_head(reader.course, access, "/devoirs")
    return render_page(
        request, "classes/copy.html", reader.account, head=head, assignment=assignment, copy=view, own=False
    )


@router.get(f"{ASSIGNMENT}/copie")
def show_own_copy(request: Request, class_id: str, aid: str, reader: CurrentReader) -> Response:
    """One's own copy, without what is withheld from its author."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.sit_tests, class_id)
    assignment = editing.find_assignment(reader.db, access.school_class, aid)
    records = classes.load_student_records(reader.db, access.school_class.id, [reader.account.id])
    name = records[0].name if records else reader.account.name
    view = build_copy(reader, access, assignment, reader.account.id, name)
    head = class_head(reader.course, access)
    return render_page(
        request, "classes/copy.html", reader.account, head=head, assignment=assignment, copy=view, own=True
    )
