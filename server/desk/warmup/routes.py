"""The questions with which a class begins a lesson: prepared by who teaches, projected, answered on phones."""

from __future__ import annotations

from functools import partial
from http import HTTPStatus
from typing import Annotated, Literal

from fastapi import APIRouter, Form, Query, Request
from fastapi.responses import Response, StreamingResponse
from starlette.concurrency import run_in_threadpool

from server.base.errors import Conflict, Invalid, NotFound
from server.base.http import client_address
from server.board.dependencies import LiveBoardsOf
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read
from server.database.dependencies import DatabaseOf
from server.desk.live_parts import require_watched_class, stream_parts
from server.desk.warmup import live, views
from server.hunts.dependencies import HuntsOf
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.submissions.job_events import STREAM_HEADERS
from server.warmup import service
from server.warmup.service import NO_QUESTION, WarmUpService
from server.web.dependencies import CurrentReader
from server.web.forms import redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

MAX_NUMBER = 9
Number = Annotated[int, Query(alias="question", ge=1, le=MAX_NUMBER)]


@router.get("/classes/{class_id}/pour-commencer")
def show_questions(request: Request, class_id: str, reader: CurrentReader, utile: Literal["", "oui"] = "") -> Response:
    """Today's questions: to answer, or with the answers of the class for who teaches; `utile`: whether they serve."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_assignments, class_id)
    if access.has(Right.read_work):
        view = views.staff_page(reader.db, reader.course, access, counts_relapses=bool(utile))
        return render_page(request, "classes/warm_up.html", reader.account, page=view)
    view = views.student_page(reader.db, reader.course, access, reader.account)
    return render_page(request, "classes/warm_up_answers.html", reader.account, page=view)


@router.post("/classes/{class_id}/pour-commencer")
async def prepare_questions(
    request: Request, class_id: str, account: SignedIn, course: CourseOf, database: DatabaseOf, hunts: HuntsOf
) -> Response:
    """Prepare the questions of today; say why where there are none."""
    try:
        await WarmUpService(course, database, hunts).prepare_today(account, class_id, client_address(request))
    except Conflict as conflict:
        return await run_in_threadpool(_refuse, request, class_id, account, course, database, conflict.detail)
    return redirect(f"/classes/{class_id}{views.PATH}")


def _refuse(
    request: Request, class_id: str, account: SignedIn, course: CourseOf, database: DatabaseOf, problem: str
) -> Response:
    with database.read() as db:
        access = rights.require_right(db, account, Right.run_lessons, class_id)
        view = views.staff_page(db, course, access, problem)
    return render_page(request, "classes/warm_up.html", account, status=HTTPStatus.CONFLICT, page=view)


@router.post("/classes/{class_id}/pour-commencer/reponses")
def answer_question(
    request: Request,
    class_id: str,
    account: SignedIn,
    reader: CurrentReader,
    question: Annotated[int, Form(ge=1, le=MAX_NUMBER)],
    reponse: Annotated[str, Form(max_length=10)] = "",
) -> Response:
    """Store the first answer to a question; a later one changes nothing."""
    access = rights.require_right(reader.db, account, Right.answer_questions, class_id)
    try:
        service.store_student_answer(reader.db, account, access.school_class, question - 1, reponse)
    except Invalid as refused:
        roll_back_then_read(reader.db)
        access = rights.require_right(reader.db, account, Right.answer_questions, class_id)
        view = views.student_page(reader.db, reader.course, access, account, refused.detail)
        return render_page(
            request, "classes/warm_up_answers.html", account, status=HTTPStatus.UNPROCESSABLE_ENTITY, page=view
        )
    return redirect(f"{views.warm_up_href(access.school_class)}#question-{question}")


@router.get("/classes/{class_id}/pour-commencer/projeter")
def project_question(
    request: Request, class_id: str, reader: CurrentReader, number: Number = 1, reponses: Literal["", "oui"] = ""
) -> Response:
    """Show one question to the class, and the numbers of answers once they are asked for."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    view = views.wall_page(reader.db, access, number - 1, shows_answers=bool(reponses))
    if view is None:
        raise NotFound(NO_QUESTION)
    return render_page(request, "classes/warm_up_wall.html", reader.account, page=view)


@router.get("/classes/{class_id}/pour-commencer/evenements")
async def stream_answers(
    class_id: str,
    account: SignedIn,
    database: DatabaseOf,
    boards: LiveBoardsOf,
    number: Number = 1,
    mur: Literal["", "oui"] = "",
    reponses: Literal["", "oui"] = "",
) -> StreamingResponse:
    """Stream the numbers of answers, as HTML; `mur`: those of one projected question."""
    access, allowed = await require_watched_class(database, account, boards, class_id)
    shown = boards.stream_view(live.WARM_UP, access.school_class.id, account.id, allowed)
    wall = partial(live.render_wall, number=number - 1, shows_answers=bool(reponses))
    stream = stream_parts(shown, wall if mur else live.render_counts)
    return StreamingResponse(stream, media_type="text/event-stream", headers=STREAM_HEADERS)
