"""The pages' addresses. Each function opens nothing and decides nothing: services do."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Sequence
from dataclasses import replace
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Query, Request, Response
from fastapi.responses import HTMLResponse, JSONResponse, RedirectResponse, StreamingResponse
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import FormData

from server.assignments.sittings import StaleWorkError
from server.base import root_path
from server.base.app_services import app_service_getter
from server.base.errors import Invalid
from server.base.http import SAFE_METHODS, client_address
from server.comments import service as comments
from server.comments.line_tracking import LineRange
from server.comments.models import CHECK_LENGTH
from server.comments.schemas import Conversation
from server.course import Exercise
from server.course.dependencies import CourseOf
from server.course.first_reading import render_exercise_of_address
from server.database import Database
from server.database.dependencies import DatabaseOf, Db
from server.gradebook import service as gradebook
from server.gradebook.dependencies import SolutionToggle
from server.gradebook.schemas import Attempt
from server.hunts.service import HuntService
from server.identity.dependencies import BrowserAccount, OptionalAccount, SignedIn, account_or_guest
from server.identity.models import Account
from server.identity.service import AccountService
from server.pages import answers, form_state, kits, service, talk
from server.pages.home import build_home_page
from server.pages.schemas import CommonExercisePage
from server.pages.talk import MessageSubject
from server.pages.waiting import WatchedSubmission, describe_waiting
from server.submissions import variants
from server.submissions.dependencies import JobEventsOf, SubmissionsOf
from server.submissions.job_events import STREAM_HEADERS, stream_sse
from server.submissions.models import Submission
from server.submissions.service import SubmissionService, job_key, parse_submission_id
from server.web import assets
from server.web.dependencies import CurrentReader, Number, PageNumber
from server.web.forms import FormFields
from server.web.rendering import render_fragment, render_page
from server.web.threads import NO_DRAFT, UnsentMessageDraft
from server.web.views import Reader, exercise_href, find_exercise, find_module
from server.web.words import format_iso_time

MOVES_ON = 303
MAX_IDENTITY = 100  # characters of a UUID, however it is written
_database, _accounts = app_service_getter(Database), app_service_getter(AccountService)
_hunts = app_service_getter(HuntService)

router = APIRouter(include_in_schema=False)


@router.get("/static/{version}/{name:path}")
async def serve_static_file(request: Request, version: str, name: str) -> Response:
    return await assets.serve_static(request.scope, version, name)


@router.get("/")
def show_home(request: Request, reader: CurrentReader) -> HTMLResponse:
    page = build_home_page(reader)
    answer = render_page(request, "home.html", reader.account, page=page)
    _prepare_hunts_after_response(request, answer, offered=page.questions > 0)
    return answer


@router.get("/{module:module}/kit/{file}")
def download_kit(module: str, file: str, reader: CurrentReader) -> Response:
    download = kits.build_kit_download(find_module(reader.course, module), file)
    headers = {"Content-Disposition": f'attachment; filename="{file}"'}
    return Response(download.content, media_type=download.media_type, headers=headers)


@router.get("/{module:module}/exercices/{slug}", dependencies=[Depends(render_exercise_of_address)])
def show_exercise(
    request: Request,
    module: str,
    slug: str,
    reader: CurrentReader,
    reprendre: Annotated[str | None, Query(max_length=MAX_IDENTITY)] = None,
) -> HTMLResponse:
    """An exercise answered without code is dealt to an account, so that a visitor becomes a guest here already."""
    exercise, database = find_exercise(reader.course, module, slug), _database(request.app)
    if exercise.answers is not None:
        account = account_or_guest(request, reader.account, _accounts(request.app))
        seed = variants.ensure_seed_while_reading(reader.db, database, account, exercise.id)
        taken = service.find_attempt_at_exercise(reader, exercise, reprendre) if reprendre else None
        return render_exercise_page(request, replace(reader, who=lambda: account), database, exercise, seed, taken)
    taken = service.find_attempt_at_exercise(reader, exercise, reprendre) if reprendre else None
    return render_exercise_page(request, reader, database, exercise, None, taken)


def render_exercise_page(
    request: Request,
    reader: Reader,
    database: Database,
    exercise: Exercise,
    seed: int | None,
    taken: Attempt | None = None,
    draft: UnsentMessageDraft = NO_DRAFT,
    status: int = 200,
) -> HTMLResponse:
    """`seed` is that of what was dealt, in an exercise answered without code; `taken` is an attempt to go on from."""
    view: CommonExercisePage
    if seed is not None:
        view, template = answers.build_answers_page(reader, exercise, seed, taken), "exercise_answers.html"
    else:
        code = None if taken is None else taken.submission.code
        view, template = service.build_exercise_page(reader, exercise, code), "exercise.html"
    work = view.results.work
    asks = work.asks if work else talk.may_ask_question(reader, exercise)
    said = talk.build_exercise_threads(reader, exercise, asks=asks, draft=draft)
    shown: dict[str, Any] = {"page": view, "results": view.results, "talk": said}
    answer = render_page(request, template, reader.account, status=status, **shown)
    mark_conversations_seen(request, reader, database, said.unread)
    _prepare_hunts_after_response(request, answer, offered=view.results.onward is not None)
    return answer


def _prepare_hunts_after_response(request: Request, answer: Response, *, offered: bool) -> None:
    """Once a page that leads to hunts is sent, have the process that makes them ready."""
    if offered:
        answer.background = BackgroundTask(_hunts(request.app).start_process_early)


def mark_conversations_seen(
    request: Request, reader: Reader, database: Database, talks: Sequence[Conversation]
) -> None:
    """In a transaction of its own: a page only reads. (Where a form is shown again, its own is still open.)"""
    if talks and reader.account is not None and request.method in SAFE_METHODS:
        with database.write() as db:
            comments.mark_conversations_seen(db, reader.account.id, talks)


@router.get("/{module:module}/exercices/{slug}/essais")
def show_attempts(
    request: Request,
    module: str,
    slug: str,
    reader: CurrentReader,
    number: PageNumber = 1,
) -> HTMLResponse:
    exercise = find_exercise(reader.course, module, slug)
    return render_page(
        request, "attempts.html", reader.account, page=service.build_attempts_page(reader, exercise, number)
    )


def _read_code_field(fields: FormData) -> str:
    code = fields.get("code", "")
    if not isinstance(code, str):
        raise Invalid("Le code est attendu comme un texte, pas comme un fichier joint.")
    return code.replace("\r\n", "\n")


def _submit_form(
    store: SubmissionService, db: Db, account: Account, exercise: Exercise, fields: FormData, *, address: str
) -> tuple[Submission, bool]:
    """The attempt, and whether this very code had been sent already: it is no new attempt then."""
    if exercise.answers is not None:
        given = answers.read_answers_form(exercise, fields)
        return store.submit_answers(db, account, exercise.id, given, address=address), False
    code = _read_code_field(fields)
    before = gradebook.find_duplicate(db, account, exercise.id, code, exercise.version)
    return (before, True) if before else (store.submit(db, account, exercise.id, code, address=address), False)


@router.post("/{module:module}/exercices/{slug}/soumissions")
def submit_attempt(
    request: Request,
    module: str,
    slug: str,
    account: BrowserAccount,
    course: CourseOf,
    store: SubmissionsOf,
    db: Db,
    fields: FormFields,
) -> Response:
    """A browser without script goes on to the attempt's page; a script gets the addresses to follow."""
    exercise = find_exercise(course, module, slug)
    form_state.require_same_tests(db, account, exercise, fields)
    submission, again = _submit_form(store, db, account, exercise, fields, address=client_address(request))
    href, query = f"/soumissions/{submission.id}", "?deja=true" if again else ""
    if "application/json" not in request.headers.get("accept", ""):
        return RedirectResponse(href + query, MOVES_ON)
    answer = {
        "id": str(submission.id),
        "account": str(account.id),
        "text": _initial_status_text(store, db, account, submission),
        "page": root_path.external_path(href + query),
        "events": root_path.external_path(f"{href}/evenements"),
        "verdict": root_path.external_path(f"{href}/verdict{query}"),
    }
    return JSONResponse(answer, 202)


def _initial_status_text(store: SubmissionService, db: Db, account: Account, submission: Submission) -> str:
    """What there is to say until there is more; of what a test holds back, always the same."""
    held = gradebook.attempt_seen_by(db, account.id, submission, None)
    return held.held_text or describe_waiting(store.progress(db, submission))


@router.post("/{module:module}/exercices/{slug}/brouillon")
def save_test_work(
    request: Request,
    module: str,
    slug: str,
    account: SignedIn,
    course: CourseOf,
    store: SubmissionsOf,
    db: Db,
    fields: FormFields,
) -> Response:
    """Keeps what is written while one sits a test; what is there at its end is sent. A script is told when it was."""
    exercise = find_exercise(course, module, slug)
    if exercise.answers is not None:
        source = store.encode_answers(answers.read_answers_form(exercise, fields))
    else:
        source = store.encode_code(_read_code_field(fields))
    form_state.require_same_tests(db, account, exercise, fields)
    try:
        saved_at = store.save_work(db, account, exercise.id, source, form_state.read_base_version(fields))
    except StaleWorkError as error:
        other_text = "" if exercise.answers is not None else error.saved.source.decode()
        raise form_state.build_stale_work_refusal(error, account, fields, other_text) from error
    if "application/json" not in request.headers.get("accept", ""):
        return RedirectResponse(f"{exercise_href(exercise)}#essai", MOVES_ON)
    return JSONResponse({"saved_at": format_iso_time(saved_at), "depuis": saved_at.isoformat()})


@router.post("/{module:module}/exercices/{slug}/corrige")
def open_or_close_solution(module: str, slug: str, course: CourseOf, set_open: SolutionToggle) -> RedirectResponse:
    exercise = find_exercise(course, module, slug)
    set_open(exercise.id)
    return RedirectResponse(f"{exercise_href(exercise)}#corrige", MOVES_ON)


@router.get("/soumissions/{submission_id}")
def show_attempt(
    request: Request,
    submission_id: str,
    reader: CurrentReader,
    deja: bool = False,
    ligne: Number | None = None,
    derniere: Number | None = None,
    verification: Annotated[str, Query(max_length=CHECK_LENGTH)] = "",
) -> HTMLResponse:
    """`deja`: it was sent again, and is told to have been sent already. The rest is what one wants to write of."""
    attempt = gradebook.find_attempt(reader.db, reader.account, submission_id)
    lines = None if ligne is None else LineRange(ligne, max(ligne, derniere or ligne))
    return render_attempt_page(
        request, reader, _database(request.app), attempt, MessageSubject(lines, verification), again=deja
    )


def render_attempt_page(
    request: Request,
    reader: Reader,
    database: Database,
    attempt: Attempt,
    aim: MessageSubject,
    *,
    again: bool = False,
    status: int = 200,
) -> HTMLResponse:
    exercise = find_exercise(reader.course, *attempt.submission.exercise.split("/"))
    answered = None if exercise.answers is None else answers.build_transcript(exercise, attempt.submission)
    view = service.build_attempt_page(reader, exercise, attempt, answered, again=again)
    work = view.results.work
    said = talk.build_attempt_threads(reader, exercise, attempt, aim, asks=work is not None and work.asks)
    answer = render_page(
        request, "attempt.html", reader.account, status=status, page=view, results=view.results, talk=said
    )
    mark_conversations_seen(request, reader, database, said.unread)
    return answer


@router.get("/soumissions/{submission_id}/verdict")
def show_verdict_fragment(
    request: Request, submission_id: str, reader: CurrentReader, deja: bool = False
) -> HTMLResponse:
    attempt = gradebook.find_attempt(reader.db, reader.account, submission_id)
    exercise = find_exercise(reader.course, *attempt.submission.exercise.split("/"))
    results = service.build_attempt_page(reader, exercise, attempt, again=deja).results
    answer = render_fragment("fragment.html", reader.account, back=exercise_href(exercise), results=results)
    _prepare_hunts_after_response(request, answer, offered=results.onward is not None)
    return answer


@router.get("/soumissions/{submission_id}/evenements")
async def stream_submission_events(
    submission_id: str, account: OptionalAccount, store: SubmissionsOf, database: DatabaseOf, hub: JobEventsOf
) -> StreamingResponse:
    identity = parse_submission_id(submission_id)
    watch = WatchedSubmission(account, store, database, identity)
    await run_in_threadpool(watch.read_state)  # a 404 must come before the stream begins
    snapshots = hub.follow(job_key(identity), watch.read_state)
    lines: AsyncIterator[str] = stream_sse(snapshots, lambda snapshot: json.dumps(snapshot.to_json()))
    return StreamingResponse(lines, media_type="text/event-stream", headers=STREAM_HEADERS)
