"""The gradebook of a class: its table, one mark and what is set in its place, what one takes away."""

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, Response, StreamingResponse

from server.base.errors import Invalid, NotFound, ServiceError
from server.base.validation import parse_uuid
from server.course.dependencies import CourseOf
from server.database import utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk.asking import UNKNOWN_ACTION, Group, log_in_first
from server.desk.marks.mark_views import mark_page
from server.desk.marks.schemas import MarkForm
from server.desk.marks.views import UNKNOWN, GradebookQuery, gradebook_page
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.marks import repository, service
from server.marks.copies import copies, files_of
from server.marks.downloads import GradebookFormat, render_download
from server.marks.files import MoodleIdentifier, file_name
from server.marks.loading import load_gradebook, load_inputs
from server.personal.zipping import zipped
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader
from server.web.forms import Field, redirect
from server.web.rendering import render_page
from server.web.words import short_moment

router = APIRouter(include_in_schema=False)

Name = Annotated[str, Query(max_length=300)]
PageNumber = Annotated[int, Query(ge=1, le=10**6)]
EMPTY = MarkForm()


@router.get("/classes/{class_id}/carnet")
def gradebook(
    request: Request, class_id: str, reader: CurrentReader, groupe: Group = "", devoir: Name = "", tri: Name = "",
    colonne: Name = "", p: PageNumber = 1,
) -> Response:  # fmt: skip
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    inputs = load_inputs(reader.db, reader.course, place.school_class, utc_now())
    view = gradebook_page(reader.db, place, inputs, GradebookQuery(groupe, devoir, tri, colonne, p))
    return render_page(request, "classes/gradebook.html", reader.account, page=view)


@router.get("/classes/{class_id}/carnet/fichier")
def file(
    class_id: str, account: SignedIn, db: Db, course: CourseOf, format: GradebookFormat = GradebookFormat.xlsx,
    identifiant: MoodleIdentifier = MoodleIdentifier.email,
) -> Response:  # fmt: skip
    place = rights.require_right(db, account, Right.read_marks, class_id)
    made = render_download(load_gradebook(db, course, place.school_class, utc_now()), format, identifiant, short_moment)
    return Response(made.content, media_type=made.media_type, headers=made.headers)


@router.get("/classes/{class_id}/carnet/copies")
def archive(
    class_id: str, account: SignedIn, database: DatabaseOf, course: CourseOf, devoir: Name = "",
    noms: Annotated[bool, Query()] = False,
) -> StreamingResponse:  # fmt: skip
    """The attempts that count, sent while the archive is made."""
    with database.read() as db:
        place = rights.require_right(db, account, Right.read_marks, class_id)
        made = load_gradebook(db, course, place.school_class, utc_now())
    found = copies(made, course, names=noms, only=parse_uuid(devoir, UNKNOWN) if devoir else None, when=short_moment)
    headers = {
        "Content-Disposition": f'attachment; filename="{file_name(made, "copies", "zip")}"',
        "Content-Encoding": "identity",
        "Cache-Control": "private, no-store",
    }
    return StreamingResponse(zipped(files_of(database, found), made.at), media_type="application/zip", headers=headers)


@router.get("/classes/{class_id}/carnet/{student}/{assignment_id}")
def one(request: Request, class_id: str, student: str, assignment_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.read_marks, class_id)
    return _one(request, reader.account, reader.db, reader.course, place, student, assignment_id)


def _one(
    request: Request, account: Account, db: Db, course: CourseOf, place: ClassAccess, student: str, assignment: str,
    form: MarkForm = EMPTY, status: int = 200,
) -> HTMLResponse:  # fmt: skip
    made = load_gradebook(db, course, place.school_class, utc_now(), only=[parse_uuid(student, UNKNOWN)])
    view = mark_page(course, place, made, assignment)
    return render_page(request, "classes/mark.html", account, status=status, page=view, form=form)


@router.post("/classes/{class_id}/carnet/{student}/{assignment_id}")
def change(
    request: Request, class_id: str, student: str, assignment_id: str, account: SignedIn, db: Db, course: CourseOf,
    action: Field = "", exercice: Field = "", points: Field = "", motif: Field = "",
) -> Response:  # fmt: skip
    """Sets a mark, or takes that back."""
    place = rights.require_right(db, account, Right.change_marks, class_id)
    try:
        _change(db, course, place, account, student, action, MarkForm(exercice, points, motif))
    except ServiceError as refused:
        if not isinstance(refused, Invalid):
            raise
        form = MarkForm(exercice, points, motif, refused.detail)
        return _one(request, account, db, course, place, student, assignment_id, form, status=422)
    return redirect(f"{request.url.path}#{exercice.rpartition('/')[2]}")


def _change(
    db: Db, course: CourseOf, place: ClassAccess, account: Account, student: str, action: str, form: MarkForm
) -> None:
    """Raises NotFound, Conflict or Invalid."""
    who, school_class = parse_uuid(student, UNKNOWN), place.school_class
    if action == "retirer":
        return service.withdraw_override(db, course, school_class, account, who, form.exercise, form.reason)
    points, excused, reason = None, action == "dispenser", form.reason
    if action == "garder":
        kept = repository.find_override(db, school_class.id, who, form.exercise)
        if kept is None:
            raise NotFound(service.NOTHING_SET)
        points, excused, reason = kept.points, kept.excused, kept.reason
    elif action == "noter":
        points = service.parse_points(form.points)
    elif not excused:
        raise NotFound(UNKNOWN_ACTION)
    service.set_override(
        db, course, school_class, account, who, form.exercise, points=points, excused=excused, reason=reason
    )
    return None
