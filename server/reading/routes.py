"""The addresses of what one reads: a module's page, its lessons, its glossary, its drawings, its search."""

from __future__ import annotations

from dataclasses import asdict
from datetime import date
from http import HTTPStatus
from typing import Annotated, Literal

from fastapi import APIRouter, Depends, Form, Request, Response
from fastapi.responses import HTMLResponse, JSONResponse, RedirectResponse

from graders.core.answers.numbers import MAX_LENGTH
from graders.typography import french
from server.base import root_path
from server.base.app_services import app_service
from server.base.errors import Invalid, NotFound
from server.base.http import client_address
from server.base.turns import out_of_turn
from server.base.validation import TruncateTo
from server.course.dependencies import CourseOf
from server.course.first_reading import SingleFlightOf, render_glossary_of_address, render_lesson_of_address
from server.database.dependencies import DatabaseOf, Db
from server.figures.dependencies import FiguresOf
from server.figures.drawing_requests import MEDIA_TYPES, Theme
from server.gradebook.dependencies import SolutionToggle
from server.identity.dependencies import BrowserAccount, load_session_account
from server.polls import service as polls
from server.polls.models import POLL_LENGTH
from server.reading import search, service
from server.reading.downloads import DownloadArchives
from server.reading.schemas import LessonAnswerInput
from server.recall import paths, retrievals
from server.web.dependencies import CurrentReader
from server.web.rendering import add_etag, render_backquotes_as_code, render_page
from server.web.views import build_module_link, find_module, lesson_href

FIGURE_POLICY = "default-src 'none'; style-src 'unsafe-inline'; sandbox"
FIGURE_HEADERS = {"Cache-Control": "public, max-age=600", "Content-Security-Policy": FIGURE_POLICY}

SearchText = Annotated[str, TruncateTo(search.MAX_QUERY_LENGTH)]
DownloadsOf = Annotated[DownloadArchives, Depends(app_service(DownloadArchives))]

router = APIRouter(include_in_schema=False)


@router.get("/{module:module}")
def show_course_home(request: Request, module: str, reader: CurrentReader) -> HTMLResponse:
    course_module = find_module(reader.course, module)
    return render_page(request, "module.html", reader.account, page=service.build_course_home(reader, course_module))


@router.post("/{module:module}/chemin")
def choose_path(
    module: str, course: CourseOf, account: BrowserAccount, db: Db, chemin: Annotated[str, Form(max_length=200)] = ""
) -> RedirectResponse:
    """Store the path that the reader takes, which decides of their next exercises; none where it is empty."""
    paths.save_chosen_path(db, account.id, find_module(course, module), chemin)
    return RedirectResponse(f"/{module}", HTTPStatus.SEE_OTHER)


@router.get("/{module:module}/lire/{slug}", dependencies=[Depends(render_lesson_of_address)])
def show_lesson(
    request: Request, module: str, slug: str, reader: CurrentReader, ouvrir: Literal["", "oui"] = ""
) -> HTMLResponse:
    """`ouvrir`: the answers of a paper, once one has read the warning before them."""
    course_module = find_module(reader.course, module)
    found = service.find_lesson(course_module, slug)
    view = service.build_lesson_page(reader, course_module, found, is_warning_read=bool(ouvrir))
    return render_page(request, "reading/lesson.html", reader.account, page=view)


@router.post("/{module:module}/lire/{slug}/corrige")
def open_or_close_exam_answers(module: str, slug: str, course: CourseOf, door: SolutionToggle) -> RedirectResponse:
    """The answers of a paper."""
    found = service.find_lesson(find_module(course, module), slug)
    if not found.solution:
        raise NotFound("Cette page n’est pas un corrigé.")
    door(found.id)
    return RedirectResponse(lesson_href(found), HTTPStatus.SEE_OTHER)


@router.post("/{module:module}/previsions")
def store_question_answer(module: str, body: LessonAnswerInput, reader: CurrentReader) -> JSONResponse:
    """Keeps what somebody answers to a question of the lessons; tells what they answered first, and if it is right."""
    course_module = find_module(reader.course, module)
    poll = polls.find_poll(course_module, body.question)
    marked = polls.submit_poll_answer(reader.db, reader.account, course_module, poll, body.answer)
    told = {**asdict(marked), "why": root_path.with_external_paths(marked.why)}
    return JSONResponse(told, headers={"Cache-Control": "no-store"})


@router.post("/{module:module}/rappels")
def mark_retrieval_answer(
    request: Request,
    module: str,
    course: CourseOf,
    database: DatabaseOf,
    question: Annotated[str, Form(max_length=POLL_LENGTH)],
    jour: Annotated[date, Form()],
    reponse: Annotated[str, Form(max_length=MAX_LENGTH)] = "",
) -> Response:
    """Mark an answer to a retrieval question: as JSON for a script, else on a page of its own, after it is stored."""
    course_module, account = find_module(course, module), load_session_account(request, database)
    wants_json = "application/json" in request.headers.get("accept", "")
    marking, refusal = None, ""
    try:
        with database.write() as db:
            marking = retrievals.submit_retrieval(db, course_module, question, account, jour, reponse)
    except Invalid as error:
        if wants_json:
            raise
        refusal = str(error)
    if marking is not None and wants_json:
        why = str(render_backquotes_as_code(french(marking.why)))
        return JSONResponse({"right": marking.is_right, "why": why}, headers={"Cache-Control": "no-store"})
    asked = retrievals.draw_retrieval(course_module, question, account, jour)
    lesson = service.find_lesson(course_module, question.partition("/")[0])
    page = {
        "module": build_module_link(course_module), "lesson": lesson.title, "asked": asked, "typed": reponse,
        "refusal": refusal, "marking": marking,
    }  # fmt: skip
    return render_page(request, "reading/recalled_page.html", account, page=page)


@router.get("/{module:module}/glossaire", dependencies=[Depends(render_glossary_of_address)])
def show_glossary(request: Request, module: str, reader: CurrentReader) -> HTMLResponse:
    course_module = find_module(reader.course, module)
    return render_page(
        request, "reading/glossary.html", reader.account, page=service.build_glossary_page(course_module)
    )


async def prepare_search_index(course: CourseOf, once: SingleFlightOf, module: str) -> None:
    """Make the index of the address's module, if there is one, at the first search."""
    course_module = course.modules.get(module)
    if course_module is not None and not search.is_index_prepared(course_module):
        async with out_of_turn():
            await once.run((search, module), lambda: search.load_index(course_module))


@router.get("/{module:module}/recherche", dependencies=[Depends(prepare_search_index)])
def show_search_results(request: Request, module: str, reader: CurrentReader, q: SearchText = "") -> HTMLResponse:
    course_module = find_module(reader.course, module)
    return render_page(request, "reading/search.html", reader.account, page=service.build_search_page(course_module, q))


@router.get("/{module:module}/figures/{name}.svg")
async def show_lesson_figure(
    request: Request, figures: FiguresOf, module: str, name: str, theme: Theme = "light"
) -> Response:
    picture = await figures.draw_lesson_figure(module, name, theme, client_address(request))
    return add_etag(request, Response(picture, media_type=MEDIA_TYPES["svg"], headers=FIGURE_HEADERS))


@router.get("/{module:module}/fichiers/{name}.zip")
async def download_archive(downloads: DownloadsOf, once: SingleFlightOf, module: str, name: str) -> Response:
    made = await downloads.build_archive_once(module, name, once)
    headers = {"Content-Disposition": f'attachment; filename="{name}.zip"', "Cache-Control": "public, max-age=600"}
    return Response(made, media_type="application/zip", headers=headers)
