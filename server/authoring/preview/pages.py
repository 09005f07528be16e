"""What a preview adds to the real pages: what is wrong, at the foot of each, and a page for trying an exercise.

Trying is sending: the solution, the starter or a known mistake goes the way of a student's file, and its author sees
the attempt as a student would.
"""

from __future__ import annotations

import asyncio
import json
import os
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import HTMLResponse, RedirectResponse, StreamingResponse
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from graders.core.code.grading import CodeGrader
from graders.core.contract.outcomes import Outcome
from graders.core.contract.protocol import KnownSubmission
from server.authoring.preview import faults
from server.authoring.preview.check_trace import CheckTrace, draw_first_case_figure, trace_solution_checks
from server.authoring.preview.supervising import PreviewSession
from server.base.errors import NotFound
from server.base.http import client_address
from server.course import Course, Exercise, Problem
from server.course.dependencies import CourseOf
from server.course.drawings import describe_verdict_figures
from server.database.dependencies import Db
from server.figures import drawing_requests
from server.figures.dependencies import FiguresOf
from server.figures.drawing_requests import MEDIA_TYPES, Theme
from server.identity.dependencies import BrowserAccount, OptionalAccount
from server.sandbox import Sandbox
from server.submissions import variants
from server.submissions.dependencies import SubmissionsOf
from server.web.rendering import jinja_environment, render_page
from server.web.views import exercise_href, find_exercise

LOCAL_HOSTS = {"127.0.0.1", "localhost", "[::1]"}
#: Seconds between two looks at what is known of the faults.
POLL_SECONDS = 0.2
RETRY_MS = 150
SEED = 1

router = APIRouter(include_in_schema=False)


@dataclass(frozen=True)
class ServedVersion:
    """The version of the files that this process serves; `over` once it is to end."""

    session: PreviewSession
    problems: Sequence[Problem]
    sandbox: Sandbox
    stopping: Event = field(default_factory=Event)


async def _served_version(request: Request) -> ServedVersion:
    """Return the served version. Only a preview's application has one."""
    version: ServedVersion = request.app.state.preview
    return version


VersionOf = Annotated[ServedVersion, Depends(_served_version)]


@dataclass(frozen=True)
class FaultView:
    place: str
    line: int | None
    message: str


@dataclass(frozen=True)
class TrialView:
    """A known submission to try, and its expected outcome."""

    number: int
    subject: str
    expected: str


@dataclass(frozen=True)
class TrialPage:
    title: str
    href: str
    action: str
    trials: tuple[TrialView, ...]
    checks: tuple[CheckTrace, ...]
    seed: int


@router.get("/apercu/evenements")
async def stream_events(version: VersionOf) -> StreamingResponse:
    return StreamingResponse(
        _event_stream(version), media_type="text/event-stream", headers={"Cache-Control": "no-store"}
    )


async def _event_stream(version: ServedVersion) -> AsyncIterator[str]:
    """Which version is served, then when its faults are known; it ends with the version, and the browser comes back."""
    yield f"retry: {RETRY_MS}\nevent: version\ndata: {version.session.generation}\n\n"
    known = False
    while not version.stopping.is_set():
        if not known and version.session.faults_file.exists():
            known = True
            yield "event: faults\ndata: known\n\n"
        await asyncio.sleep(POLL_SECONDS)


@router.get("/apercu/problemes")
def show_problems(version: VersionOf) -> HTMLResponse:
    return HTMLResponse(render_footer(version, "", None), headers={"Cache-Control": "no-store"})


@router.get("/apercu/{module:module}/{slug}")
def show_trial_page(
    request: Request, module: str, slug: str, course: CourseOf, account: OptionalAccount, graine: int = SEED
) -> HTMLResponse:
    exercise = find_exercise(course, module, slug)
    grader, figure_descriptions = exercise.grader, describe_verdict_figures(exercise.id)
    shown = TrialPage(
        exercise.title,
        exercise_href(exercise),
        f"/apercu/{exercise.id}",
        tuple(
            TrialView(number, known.subject, _describe_expected(known))
            for number, known in enumerate(_list_trials(exercise))
        ),
        tuple(trace_solution_checks(grader, graine, figure_descriptions)) if isinstance(grader, CodeGrader) else (),
        graine,
    )
    return render_page(request, "preview/exercise.html", account, page=shown)


@router.post("/apercu/{module:module}/{slug}/{number}")
def submit_trial(
    request: Request,
    module: str,
    slug: str,
    number: int,
    course: CourseOf,
    account: BrowserAccount,
    store: SubmissionsOf,
    db: Db,
) -> Response:
    """Sends what is known, as whoever looks would; goes on to the attempt's page."""
    exercise = find_exercise(course, module, slug)
    trials = _list_trials(exercise)
    if not 0 <= number < len(trials):
        raise NotFound("Cet essai n’existe pas.")
    address = client_address(request)
    if exercise.answers is None:
        code = trials[number].source_for_seed(SEED).decode("utf-8", errors="replace")
        sent = store.submit(db, account, exercise.id, code, address=address)
    else:
        answers = json.loads(trials[number].source_for_seed(variants.get_or_create_seed(db, account, exercise.id)))
        sent = store.submit_answers(db, account, exercise.id, answers, address=address)
    return RedirectResponse(f"/soumissions/{sent.id}", 303)


@router.get("/apercu/{module:module}/{slug}/figures/{check}.svg")
async def draw_check_figure(
    request: Request, module: str, slug: str, check: str, course: CourseOf, figures: FiguresOf, theme: Theme = "light"
) -> Response:
    exercise = find_exercise(course, module, slug)
    grader = exercise.grader
    data = (
        await run_in_threadpool(draw_first_case_figure, grader, check, SEED) if isinstance(grader, CodeGrader) else None
    )
    if data is None:
        raise NotFound("Cette vérification ne dessine rien.")
    picture = await figures.pictures.load_or_render(
        drawing_requests.build_verdict_figure_request(exercise.id, data, "svg", theme), client_address(request), rank=0
    )
    return Response(picture, media_type=MEDIA_TYPES["svg"], headers={"Cache-Control": "no-store"})


def _list_trials(exercise: Exercise) -> list[KnownSubmission]:
    reference, *others = exercise.grader.known_submissions()
    return [reference, KnownSubmission("fichier de départ", lambda _: exercise.starter.encode()), *others]


def _describe_expected(known: KnownSubmission) -> str:
    if known.diagnosis is not None:
        return f"refusé, et nommé « {known.diagnosis} »"
    if known.outcome is Outcome.OK:
        return "tous les points"
    return "pas tous les points" if known.outcome is None else known.outcome.wording("code").title.lower()


def render_footer(version: ServedVersion, path: str, course: Course | None) -> str:
    """What stands at the foot of each page; `path` is its address, from which one may try its exercise."""
    found = faults.load_faults_or_known(version.session, version.problems)
    place = version.session.course_folder
    views = [FaultView(_relative_path(problem.path, place), problem.line, problem.message) for problem in found]
    looked = version.session.faults_file.exists()
    context: dict[str, Any] = {"faults": views, "looked": looked, "generation": version.session.generation}
    exercise = _trial_href_of_page(path, course)
    return jinja_environment().get_template("preview/foot.html").render(**context, exercise=exercise)


def _relative_path(path: Path, place: Path) -> str:
    return os.path.relpath(path, place) if path.is_relative_to(place) else str(path)


def _trial_href_of_page(path: str, course: Course | None) -> str:
    """Where one tries the exercise that a page is of; empty for others."""
    parts = path.strip("/").split("/")
    if course is None or len(parts) < 3 or parts[1] != "exercices":
        return ""
    name = f"{parts[0]}/{parts[2]}"
    return f"/apercu/{name}" if name in course.exercises else ""


def _is_local_request(headers: Headers) -> bool:
    """By an address of this machine, and by no other site's page, which would have it compute; links may lead here."""
    from_here = headers.get("sec-fetch-site", "none") in {"same-origin", "none"}
    return headers.get("host", "").rsplit(":", 1)[0] in LOCAL_HOSTS and (
        from_here or (headers.get("sec-fetch-mode"), headers.get("sec-fetch-dest")) == ("navigate", "document")
    )


class PreviewMiddleware:
    """The application, on this machine alone, with the foot of a preview on each of its pages."""

    def __init__(self, app: ASGIApp, version: ServedVersion, course: Course) -> None:
        self._app, self._version, self._course = app, version, course

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            return await self._app(scope, receive, send)
        if not _is_local_request(Headers(scope=scope)):
            refusal = PlainTextResponse("Cet aperçu ne répond qu’à cette machine.", 403)
            return await refusal(scope, receive, send)
        dropped = {b"accept-encoding", b"if-none-match"}
        headers = [(name, value) for name, value in scope["headers"] if name not in dropped]
        await self._app({**scope, "headers": headers}, receive, self._append_footer(scope["path"], send))

    def _append_footer(self, path: str, send: Send) -> Send:
        """Holds a page back until it is whole, and adds to it; lets everything else through."""
        started: Message | None = None
        body = b""

        async def adding(message: Message) -> None:
            nonlocal started, body
            if message["type"] == "http.response.start":
                if not Headers(raw=message["headers"]).get("content-type", "").startswith("text/html"):
                    return await send(message)
                started = message
            elif started is None:
                await send(message)
            else:
                body += message.get("body", b"")
                if not message.get("more_body", False):
                    await self._send_with_footer(path, started, body, send)

        return adding

    async def _send_with_footer(self, path: str, started: Message, body: bytes, send: Send) -> None:
        before, end, after = body.rpartition(b"</body>")
        if end:
            added = await run_in_threadpool(render_footer, self._version, path, self._course)
            body = before + added.encode() + end + after
        headers = MutableHeaders(raw=[*started["headers"]])
        headers["content-length"] = str(len(body))
        if "etag" in headers:
            del headers["etag"]
        await send({**started, "headers": headers.raw})
        await send({"type": "http.response.body", "body": body})
