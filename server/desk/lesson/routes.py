"""The lesson of a class: its page and form, its stream of changes, its view for the projector."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Annotated

from fastapi import APIRouter, Form, Query, Request
from fastapi.responses import HTMLResponse, Response, StreamingResponse

from server.base.app_services import SettingsOf
from server.base.errors import Conflict, Invalid, NotFound
from server.base.settings import Settings
from server.base.validation import parse_uuid
from server.board.dependencies import LiveBoardsOf
from server.classes.service import NOT_A_MEMBER
from server.database import roll_back_then_read, utc_now
from server.database.dependencies import DatabaseOf
from server.desk.lesson import views
from server.desk.lesson.live import LESSON, ShownLesson
from server.desk.lesson.review import review_page
from server.desk.live_parts import require_watched_class, stream_parts
from server.desk.views import class_href
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.lesson import repository, service
from server.lesson.models import Afterwards
from server.lesson.service import LessonPlan
from server.mails import service as mails
from server.mails import smtp
from server.mails.service import MailForm
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.submissions.job_events import STREAM_HEADERS
from server.web.dependencies import CurrentReader
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page
from server.web.views import Reader

router = APIRouter(include_in_schema=False)

NO_SUCH_LESSON = "Cette séance n’existe pas."
Names = Annotated[list[str], Form()]


@router.get("/classes/{class_id}/seance")
def show_lesson(request: Request, class_id: str, reader: CurrentReader) -> Response:
    """The lesson that goes on, or the form that begins one."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    return _render_lesson(request, reader, reader.account, access)


def _render_lesson(
    request: Request,
    reader: Reader,
    account: Account,
    access: ClassAccess,
    refused: tuple[LessonPlan, str] | None = None,
) -> HTMLResponse:
    now, status = utc_now(), 422 if refused else 200
    form = None if refused is None else views.lesson_form(reader.db, reader.course, access.school_class, now, *refused)
    lesson = service.find_current_lesson(reader.db, access.school_class.id, now)
    if lesson is None:
        start = views.start_page(reader.db, reader.course, access, now, form)
        return render_page(request, "classes/lesson_start.html", account, status=status, page=start)
    view = views.lesson_page(reader.db, reader.course, access, lesson, now, form)
    return render_page(request, "classes/lesson.html", account, status=status, page=view)


@router.post("/classes/{class_id}/seance")
def run_lesson(
    request: Request,
    class_id: str,
    account: SignedIn,
    reader: CurrentReader,
    action: Field = "",
    exercice: Names = [],  # noqa: B006 (FastAPI copies it)
    suite: Field = Afterwards.none.value,
    defi: Field = "",
    eleve: Field = "",
) -> Response:
    """Begin, change or end the lesson; or mark a student as seen: `eleve` is their id and the exercise."""
    access = rights.require_right(reader.db, account, Right.run_lessons, class_id)
    school_class, now = access.school_class, utc_now()
    href = f"{class_href(school_class)}/seance"
    step = Afterwards(suite) if suite in set(Afterwards) else Afterwards.none
    plan = LessonPlan(tuple(exercice), step, defi)
    try:
        if action == "commencer":
            service.start_lesson(reader.db, reader.course, school_class, account.id, plan, now)
        elif action == "modifier":
            service.change_lesson(reader.db, reader.course, school_class, account.id, plan, now)
        elif action == "terminer":
            ended = service.end_lesson(reader.db, school_class, account.id, now)
            return redirect(f"{href}/{ended.id}")
        elif action == "vu":
            student, _, exercise = eleve.partition(" ")
            identity = parse_uuid(student, NOT_A_MEMBER)
            service.record_student_visit(reader.db, school_class, account.id, identity, exercise, now)
        else:
            raise Invalid(UNKNOWN_ACTION)
    except (Conflict, Invalid) as refused:
        if action not in {"commencer", "modifier"}:
            raise
        roll_back_then_read(reader.db)
        again = rights.require_right(reader.db, account, Right.run_lessons, class_id)
        return _render_lesson(request, reader, account, again, (plan, refused.detail))
    return redirect(href)


@router.get("/classes/{class_id}/seance/projeter")
def project_lesson(request: Request, class_id: str, reader: CurrentReader) -> Response:
    """Show the exercises of the day and how far the class is, without any name."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    now = utc_now()
    lesson = service.require_current_lesson(reader.db, access.school_class.id, now)
    view = views.lesson_page(reader.db, reader.course, access, lesson, now, None)
    return render_page(request, "classes/lesson_wall.html", reader.account, page=view)


@router.get("/classes/{class_id}/seance/evenements")
async def stream_lesson(
    class_id: str, account: SignedIn, database: DatabaseOf, boards: LiveBoardsOf,
    mur: Annotated[str, Query(max_length=10)] = "",
) -> StreamingResponse:  # fmt: skip
    """Stream the parts of the page that change, as HTML; `mur`: of the view for the projector."""
    access, allowed = await require_watched_class(database, account, boards, class_id)
    shown = boards.stream_view(LESSON, access.school_class.id, account.id, allowed)
    render = views.render_wall if mur else partial(views.render_parts, access=access)

    def render_shown(lesson: ShownLesson) -> Mapping[str, str] | None:
        return None if lesson.parts is None else render(lesson.parts)

    stream = stream_parts(shown, render_shown)
    return StreamingResponse(stream, media_type="text/event-stream", headers=STREAM_HEADERS)


@router.get("/classes/{class_id}/seance/{lesson_id}")
def review_lesson(
    request: Request, class_id: str, lesson_id: str, reader: CurrentReader, settings: SettingsOf
) -> Response:
    """Say what a lesson leaves to do."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    identity = parse_uuid(lesson_id, NO_SUCH_LESSON)
    lesson = repository.find_lesson(reader.db, access.school_class.id, identity)
    if lesson is None:
        raise NotFound(NO_SUCH_LESSON)
    view = review_page(reader.db, reader.course, access, utc_now(), lesson)
    mail = _mail_form(reader, settings, access)
    return render_page(request, "classes/lesson_review.html", reader.account, page=view, mail=mail)


@router.get("/classes/{class_id}/semaine")
def review_week(request: Request, class_id: str, reader: CurrentReader, settings: SettingsOf) -> Response:
    """Say what the last seven days leave to do."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    view = review_page(reader.db, reader.course, access, utc_now(), None)
    mail = _mail_form(reader, settings, access)
    return render_page(request, "classes/lesson_review.html", reader.account, page=view, mail=mail)


def _mail_form(reader: Reader, settings: Settings, access: ClassAccess) -> MailForm | None:
    """Return the form that asks for the page by mail; None where no server takes mails, or the class is archived."""
    if reader.account is None or not smtp.is_smtp_configured(settings) or access.school_class.archived_at is not None:
        return None
    return mails.load_mail_form(reader.db, access.school_class.id, reader.account)
