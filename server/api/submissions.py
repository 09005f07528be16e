"""Sending files and following them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

from fastapi import APIRouter, Depends, Header, Query, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response, StreamingResponse
from sqlalchemy.exc import DBAPIError
from starlette.concurrency import run_in_threadpool

from server.api.documentation import event_stream_response, problem_responses, text_response
from server.api.exercises import find_exercise_by_id
from server.api.schemas import NewSubmission, SubmissionOut
from server.api.state import SubmissionResource, build_submission_resource, make_resource_reader, submission_url
from server.base.app_services import app_service_getter
from server.base.http import client_address
from server.course.models import Course, Exercise
from server.database import Database, is_unavailable
from server.database.dependencies import DatabaseOf, Db
from server.figures.dependencies import FiguresOf
from server.figures.drawing_requests import MEDIA_TYPES, Form, Theme
from server.figures.service import VerdictFigureQuery
from server.gradebook import service as gradebook
from server.identity.dependencies import ApiAccount, BearerToken, TokenFirstRoute, account_of_token
from server.identity.models import Account
from server.submissions.dependencies import JobEventsOf, SubmissionsOf
from server.submissions.job_events import STREAM_HEADERS, JobEvents, stream_sse
from server.submissions.service import SubmissionService, job_key, parse_submission_id

router = APIRouter(tags=["submissions"], route_class=TokenFirstRoute)

_database, _course = app_service_getter(Database), app_service_getter(Course)
_store_of, _hub = app_service_getter(SubmissionService), app_service_getter(JobEvents)

LONGEST_WAIT = 30.0
Wait = Annotated[
    float | None,
    Query(ge=0, allow_inf_nan=False, description="Seconds to wait for the verdict, 30 at most.", examples=[10]),
]
Reuse = Annotated[
    bool,
    Query(description="With code that this account has sent already, answers with that attempt: no new one is made."),
]
SendingKey = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=200,
        description="A name of this sending, of one's own: sent again with the same, it is stored once.",
        examples=["5d1c6c0e-6b1f-4b0e-9d7e-0a4c7a0e8f11"],
    ),
]
STREAM = event_stream_response(
    "Its data is as in `GET /submissions/{id}`; ends when done, or at once where a test holds it.", "status"
)


@router.post(
    "/submissions",
    status_code=202,
    response_model=SubmissionOut,
    responses={
        200: {"description": "Graded within `wait` seconds.", "model": SubmissionOut},
        202: {"description": "Stored; follow it at `url`."},
        **problem_responses(400, 401, 404, 409, 413, 422, 429, 503),
    },
)
async def create(
    request: Request,
    body: NewSubmission,
    token: BearerToken,
    wait: Wait = None,
    reuse: Reuse = False,
    key: SendingKey = None,
) -> Response:
    """Stores a file, or answers, and queues it. With `wait`, answers as soon as the verdict is there.

    Where a test holds the verdict back, only that the file does not run is waited for (`load_error`), some seconds at
    most; 409 before one has begun the test, and after its end.
    Whoever had no answer, or 503, may send the same again with the same `Idempotency-Key`.
    """
    sending = SendingOptions(body, reuse, client_address(request), key, waits=bool(wait))
    database, store, course = _database(request.app), _store_of(request.app), _course(request.app)

    def stored() -> tuple[Account, SubmissionResource]:
        account = account_of_token(token, database)
        return account, _store_submission(database, store, account, sending, course)

    account, current = await run_in_threadpool(stored)
    if wait and not current.done:
        look = make_resource_reader(database, store, account, current.id)
        longest = LONGEST_WAIT if current.settles_in is None else current.settles_in
        current = await _wait_until_done(_hub(request.app), look, current, min(wait, longest))
    return _json_response(current, 200 if current.done and not current.held else 202)


def _require_content_of_kind(exercise: Exercise, body: NewSubmission) -> None:
    """Exactly one of `code` and `answers`, the one that this exercise asks for. Raises RequestValidationError."""
    other = {"code": "answers", "answers": "code"}[exercise.kind]
    faults: list[tuple[str, str]] = [(exercise.kind, "missing")] if exercise.kind not in body.model_fields_set else []
    if other in body.model_fields_set:
        faults.append((other, "extra_forbidden"))
    if faults:
        raise RequestValidationError([{"type": fault, "loc": ("body", name), "msg": ""} for name, fault in faults])


@dataclass(frozen=True)
class SendingOptions:
    """`reuse`: an attempt with the same code at the exercise's version will do; `key` is the sender's name for it. Who
    `waits` for the verdict is not told the place of what was stored."""

    body: NewSubmission
    reuse: bool
    address: str
    key: str | None
    waits: bool = False


def _store_submission(
    database: Database, store: SubmissionService, account: Account, sending: SendingOptions, course: Course
) -> SubmissionResource:
    body, address = sending.body, sending.address
    exercise = find_exercise_by_id(course, body.exercise)
    _require_content_of_kind(exercise, body)
    with database.write() as db:
        answered = "answers" in body.model_fields_set
        if sending.reuse and not answered:
            before = gradebook.find_duplicate(db, account, body.exercise, body.code, exercise.version)
            if before is not None:
                return build_submission_resource(db, store, gradebook.find_attempt(db, account, before.id))
        if answered:
            submission = store.submit_answers(
                db, account, body.exercise, body.answers, address=address, key=sending.key
            )
        else:
            submission = store.submit(db, account, body.exercise, body.code, address=address, key=sending.key)
        if submission.grading_id is not None:  # sent again, and graded meanwhile
            return build_submission_resource(db, store, gradebook.find_attempt(db, account, submission.id))
        return build_submission_resource(
            db, store, gradebook.attempt_seen_by(db, account.id, submission, None), placed=not sending.waits
        )


async def _wait_until_done(
    hub: JobEvents, read: Callable[[], SubmissionResource], current: SubmissionResource, seconds: float
) -> SubmissionResource:
    """It is stored: that the database is away meanwhile takes nothing from that."""
    try:
        return await hub.wait_until_done(job_key(current.id), read, seconds)
    except DBAPIError as error:
        if not is_unavailable(error):
            raise
        return current


def _json_response(current: SubmissionResource, status: int = 200) -> Response:
    return Response(current.text, status, {"Location": submission_url(current.id)}, "application/json")


@router.get("/submissions/{submission_id}", response_model=SubmissionOut, responses=problem_responses(401, 404))
def read(submission_id: str, store: SubmissionsOf, account: ApiAccount, db: Db) -> Response:
    """The submission as it stands."""
    current = build_submission_resource(db, store, gradebook.find_attempt(db, account, submission_id))
    return Response(current.text, media_type="application/json")


@router.get(
    "/submissions/{submission_id}/events",
    response_class=Response,
    responses={200: STREAM, **problem_responses(401, 404)},
)
async def follow(
    submission_id: str, store: SubmissionsOf, hub: JobEventsOf, account: ApiAccount, database: DatabaseOf
) -> Response:
    """The submission each time that it changes, as server-sent events."""
    identity = parse_submission_id(submission_id)
    read = make_resource_reader(database, store, account, identity)
    await run_in_threadpool(read)  # a 404 must come before the stream begins
    stream = stream_sse(hub.follow(job_key(identity), read), lambda current: current.text)
    return StreamingResponse(stream, headers=STREAM_HEADERS, media_type="text/event-stream")


class FigureRequest:
    """One's own submission, and the name of one of its figures."""

    def __init__(
        self,
        request: Request,
        figures: FiguresOf,
        submission_id: str,
        name: str,
        account: ApiAccount,
        theme: Theme = "light",
    ) -> None:
        self._figures, self._account, self._address = figures, account, client_address(request)
        self._submission_id, self._name, self._theme = submission_id, name, theme

    async def answer(self, form: Form) -> Response:
        wanted = VerdictFigureQuery(self._submission_id, self._name, form, self._theme)
        picture = await self._figures.draw_verdict_figure(self._account, wanted, self._address)
        return Response(picture, media_type=MEDIA_TYPES[form], headers={"Cache-Control": "private, no-cache"})


@router.get(
    "/submissions/{submission_id}/figures/{name}.svg",
    response_class=Response,
    responses={200: text_response("The figure.", "image/svg+xml"), **problem_responses(401, 404, 422, 503)},
)
async def figure_svg(figure: Annotated[FigureRequest, Depends()]) -> Response:
    """A figure that the verdict names, drawn on demand."""
    return await figure.answer("svg")


@router.get(
    "/submissions/{submission_id}/figures/{name}.png",
    response_class=Response,
    responses={200: text_response("The figure.", "image/png"), **problem_responses(401, 404, 422, 503)},
)
async def figure_png(figure: Annotated[FigureRequest, Depends()]) -> Response:
    """The same, as a bitmap."""
    return await figure.answer("png")
