"""Pages of one student, for who teaches them: each exercise, and the attempts at one with what each changed."""

from __future__ import annotations

from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.base.app_services import SettingsOf
from server.base.errors import Conflict, Invalid, RateLimited
from server.comments import notes, service
from server.database import roll_back_then_read
from server.desk.talk import work_views
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader, Number, PageNumber
from server.web.forms import Field, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.threads import NO_DRAFT, UnsentMessageDraft
from server.web.views import Reader

router = APIRouter(include_in_schema=False)


@router.get("/classes/{class_id}/eleves/{student}")
def show_student(request: Request, class_id: str, student: UUID, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    view = work_views.build_student_page(reader, work_views.find_student_work(reader, access, student))
    return render_page(request, "classes/student.html", reader.account, page=view)


@router.get("/classes/{class_id}/eleves/{student}/{module}/{slug}")
def show_attempts(
    request: Request,
    class_id: str,
    student: UUID,
    module: str,
    slug: str,
    reader: CurrentReader,
    essai: Number | None = None,
    number: PageNumber = 1,
) -> Response:
    """`essai` is the attempt of which one wants to see what it changed."""
    if reader.account is None:
        return redirect_to_login(request)
    where = (class_id, student, module, slug)
    return _render_work(request, reader, reader.account, where, Right.read_work, essai, number)


def _render_work(
    request: Request,
    reader: Reader,
    account: Account,
    where: tuple[str, UUID, str, str],
    right: Right,
    chosen: int | None = None,
    number: int = 1,
    draft: UnsentMessageDraft = NO_DRAFT,
    status: int = 200,
) -> HTMLResponse:
    class_id, student, module, slug = where
    access = rights.require_right(reader.db, account, right, class_id)
    exercise = work_views.find_class_exercise(reader, access, module, slug)
    of_whom = work_views.find_student_work(reader, access, student)
    view = work_views.build_work_page(reader, of_whom, exercise, account, chosen, number, draft)
    return render_page(request, "classes/work.html", account, status=status, page=view)


@router.post("/classes/{class_id}/eleves/{student}/{module}/{slug}")
def comment_on_exercise(
    request: Request,
    class_id: str,
    student: UUID,
    module: str,
    slug: str,
    account: SignedIn,
    reader: CurrentReader,
    settings: SettingsOf,
    texte: Field = "",
    phrase: Field = "",
    garder: Field = "",
) -> Response:
    """Says something of a student's work in an exercise, whatever the attempt."""
    access = rights.require_right(reader.db, account, Right.comment, class_id)
    exercise = work_views.find_class_exercise(reader, access, module, slug)
    of_whom = work_views.find_student_work(reader, access, student)
    try:
        text = notes.prepend_phrase(reader.db, account, notes.parse_phrase_id(phrase), texte)
        thread = service.begin_exercise_thread(reader.db, account, student, exercise.id, text, settings)
    except (Invalid, Conflict, RateLimited) as refused:
        roll_back_then_read(reader.db)
        draft, where = UnsentMessageDraft(texte, refused.detail), (class_id, student, module, slug)
        return _render_work(request, reader, account, where, Right.comment, draft=draft, status=int(refused.status))
    if garder and texte.strip():
        notes.save_phrase(reader.db, account, texte, exercise.id, None)
    return redirect(f"{of_whom.exercise_href(exercise.id)}#fil-{thread.id}")
