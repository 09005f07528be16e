"""The gradebook of a class: its table, one mark and its override, and downloads."""

from dataclasses import replace
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, Response, StreamingResponse

from server.base.bulk import OneAtATimeStream
from server.base.errors import Invalid, NotFound
from server.base.validation import parse_uuid
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read, utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk.marks.mark_views import average_page, changed_texts, mark_page, stored_texts
from server.desk.marks.schemas import MarkForm
from server.desk.marks.views import UNKNOWN, GradebookQuery, gradebook_page
from server.desk.requests import GroupQuery
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.marks import decisions, repository, service
from server.marks.copies import iter_archive_files, list_counting_attempt_files
from server.marks.downloads import GradebookFormat, render_download
from server.marks.files import MoodleIdentifier, gradebook_file_name
from server.marks.loading import load_gradebook, load_inputs
from server.personal.zip_stream import stream_zip
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader, Number
from server.web.form_version import form_version_tag, require_form_version
from server.web.forms import UNKNOWN_ACTION, Field, FormFields, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.words import format_short_time

router = APIRouter(include_in_schema=False)

Name = Annotated[str, Query(max_length=300)]
EMPTY = MarkForm()
SET_MEANWHILE = (
    "Quelqu’un d’autre a changé les notes de cet élève à ce devoir depuis que cette page est ouverte. Rien de votre "
    "saisie n’est encore enregistré, et rien n’est perdu."
)
SAVE_MINE = "Enregistrer ma version"
#: The value of the field `portee` of an override that holds in all assignments.
EVERYWHERE = "partout"


@router.get("/classes/{class_id}/carnet")
def show_gradebook(
    request: Request, class_id: str, reader: CurrentReader, groupe: GroupQuery = "", devoir: Name = "", tri: Name = "",
    colonne: Name = "", p: Number = 1, q: GroupQuery = "",
) -> Response:  # fmt: skip
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    inputs = load_inputs(reader.db, reader.course, access.school_class, utc_now())
    view = gradebook_page(reader.db, access, inputs, GradebookQuery(groupe, devoir, tri, colonne, p, q.strip()))
    return render_page(request, "classes/gradebook.html", reader.account, page=view)


@router.get("/classes/{class_id}/carnet/fichier")
def download_gradebook(
    class_id: str, account: SignedIn, db: Db, course: CourseOf, format: GradebookFormat = GradebookFormat.xlsx,
    identifiant: MoodleIdentifier = MoodleIdentifier.email,
) -> Response:  # fmt: skip
    access = rights.require_right(db, account, Right.read_marks, class_id)
    gradebook = load_gradebook(db, course, access.school_class, utc_now())
    rendered = render_download(gradebook, format, identifiant, format_short_time)
    return Response(rendered.content, media_type=rendered.media_type, headers=rendered.headers)


@router.get("/classes/{class_id}/carnet/copies")
def download_copies(
    class_id: str, account: SignedIn, database: DatabaseOf, course: CourseOf, devoir: Name = "",
    noms: Annotated[bool, Query()] = False,
) -> StreamingResponse:  # fmt: skip
    """Stream an archive of the attempts that count."""
    with database.read() as db:
        access = rights.require_right(db, account, Right.read_marks, class_id)
        gradebook = load_gradebook(db, course, access.school_class, utc_now())
    only = parse_uuid(devoir, UNKNOWN) if devoir else None
    copies = list_counting_attempt_files(gradebook, course, names=noms, only=only, format_time=format_short_time)
    headers = {
        "Content-Disposition": f'attachment; filename="{gradebook_file_name(gradebook, "copies", "zip")}"',
        "Content-Encoding": "identity",
        "Cache-Control": "private, no-store",
    }
    files = iter_archive_files(database, copies)
    return OneAtATimeStream(stream_zip(files, gradebook.at), media_type="application/zip", headers=headers)


@router.get("/classes/{class_id}/carnet/{student}")
def show_average(request: Request, class_id: str, student: str, reader: CurrentReader) -> Response:
    """« Pourquoi cette moyenne ? », for the teachers of a student."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    only = [parse_uuid(student, UNKNOWN)]
    gradebook = load_gradebook(reader.db, reader.course, access.school_class, utc_now(), only)
    view = average_page(reader.course, access, gradebook)
    return render_page(request, "classes/average.html", reader.account, page=view)


@router.get("/classes/{class_id}/carnet/{student}/{assignment_id}")
def show_mark(request: Request, class_id: str, student: str, assignment_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    return _mark_page(request, reader.account, reader.db, reader.course, access, student, assignment_id)


def _mark_page(
    request: Request, account: Account, db: Db, course: CourseOf, access: ClassAccess, student: str, assignment: str,
    form: MarkForm = EMPTY, status: int = 200,
) -> HTMLResponse:  # fmt: skip
    only = [parse_uuid(student, UNKNOWN)]
    gradebook = load_gradebook(db, course, access.school_class, utc_now(), only)
    view = mark_page(course, access, gradebook, assignment)
    return render_page(request, "classes/mark.html", account, status=status, page=view, form=form)


@router.post("/classes/{class_id}/carnet/{student}/{assignment_id}")
def change_mark(
    request: Request, class_id: str, student: str, assignment_id: str, account: SignedIn, db: Db, course: CourseOf,
    fields: FormFields, action: Field = "", exercice: Field = "", points: Field = "", motif: Field = "",
    portee: Field = "", etat: Field = "",
) -> Response:  # fmt: skip
    """Set, keep or withdraw an override, or a decision about the whole assignment."""
    access = rights.require_right(db, account, Right.change_marks, class_id)
    school_class = access.school_class
    form = MarkForm(exercice, points, motif, portee == EVERYWHERE)
    target = parse_uuid(student, UNKNOWN), parse_uuid(assignment_id, UNKNOWN)
    service.lock_student_marks(db, school_class, target[0])
    stored = stored_texts(load_gradebook(db, course, school_class, utc_now(), target[:1]), assignment_id)
    require_form_version(
        fields, account, form_version_tag(stored), SET_MEANWHILE, SAVE_MINE, changed_texts(stored, etat, form)
    )
    try:
        if action == "decider":
            decisions.set_state_decision(db, school_class, account, *target, etat, motif)
        elif action == "annuler":
            decisions.withdraw_state_decision(db, school_class, account, *target)
        else:
            _change_override(db, course, access, account, *target, action, form)
    except Invalid as refused:
        roll_back_then_read(db)
        form = replace(form, problem=refused.detail)
        return _mark_page(request, account, db, course, access, student, assignment_id, form, status=422)
    return redirect(f"{request.url.path}#{exercice.rpartition('/')[2] or 'etat'}")


def _change_override(
    db: Db, course: CourseOf, access: ClassAccess, account: Account, student: UUID, assignment: UUID, action: str,
    form: MarkForm,
) -> None:  # fmt: skip
    """Raise NotFound, Conflict or Invalid. Overrides in the bare module of a class, no assignment, hold everywhere."""
    school_class = access.school_class
    scope = None if form.everywhere or assignment == school_class.id else assignment
    if action == "retirer":
        return service.withdraw_override(
            db, course, school_class, account, student, form.exercise, form.reason, assignment_id=scope
        )
    points, excused, reason = None, action == "dispenser", form.reason
    if action == "garder":
        override = repository.find_active_override(db, school_class.id, student, form.exercise, scope)
        if override is None:
            raise NotFound(service.NOTHING_SET)
        points, excused, reason = override.points, override.excused, override.reason
    elif action == "noter":
        points = service.parse_override_points(form.points)
    elif not excused:
        raise NotFound(UNKNOWN_ACTION)
    return service.set_override(
        db,
        course,
        school_class,
        account,
        student,
        form.exercise,
        points=points,
        excused=excused,
        reason=reason,
        assignment_id=scope,
    )
