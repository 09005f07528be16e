"""The event stream of a board, and the pages of one misconception."""

from __future__ import annotations

from collections.abc import AsyncIterator
from typing import Annotated

from fastapi import APIRouter, Header, Query, Request
from fastapi.responses import Response, StreamingResponse
from starlette.concurrency import run_in_threadpool

from server.base.http import client_address
from server.board.dependencies import LiveBoardsOf
from server.board.live import BOARD
from server.board.schemas import Board
from server.course.dependencies import CourseOf
from server.database.dependencies import DatabaseOf
from server.desk.board.changes import OpenBoard, board_events
from server.desk.board.misconception_views import misconception_page
from server.desk.board.projection import ProjectedPrograms, ProjectionPage, complete_projection, prepare_projection
from server.desk.live_parts import SIGN_OF_LIFE, require_watched_class
from server.desk.views import class_href
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.steps.routes import StepsDep
from server.submissions.job_events import STREAM_HEADERS
from server.web.dependencies import CurrentReader
from server.web.forms import redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

Text = Annotated[str, Query(max_length=200)]


@router.get("/classes/{class_id}/erreurs/{module}/{slug}/{mistake}")
def show_mistake(
    request: Request, class_id: str, module: str, slug: str, mistake: str, reader: CurrentReader
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    view = misconception_page(reader.db, reader.course, access, f"{module}/{slug}", mistake)
    return render_page(request, "classes/mistake.html", reader.account, page=view)


@router.get("/classes/{class_id}/erreurs/{module}/{slug}/{mistake}/projeter")
async def show_projection(
    request: Request,
    class_id: str,
    module: str,
    slug: str,
    mistake: str,
    reader: CurrentReader,
    steps: StepsDep,
    choix: Text = "",
) -> Response:
    """Show a misconception to the whole class, without names; of few students, only where the teacher chose so."""

    def prepare() -> tuple[Account, ProjectionPage, ProjectedPrograms | None] | None:
        account = reader.account
        if account is None:
            return None
        access = rights.require_right(reader.db, account, Right.read_work, class_id)
        return account, *prepare_projection(reader, account, access, f"{module}/{slug}", mistake, chosen=bool(choix))

    prepared = await run_in_threadpool(prepare)
    if prepared is None:
        return redirect_to_login(request)
    account, page, programs = prepared
    view = await complete_projection(page, programs, steps, account, client_address(request))
    return await run_in_threadpool(render_page, request, "classes/projection.html", account, page=view)


@router.get("/classes/{class_id}/evenements")
async def stream_board_events(
    class_id: str, account: SignedIn, database: DatabaseOf, course: CourseOf, boards: LiveBoardsOf, version: Text = "",
    erreurs: Text = "", last_event_id: Annotated[str, Header(max_length=200)] = "",
) -> StreamingResponse:  # fmt: skip
    """Stream the changes of the page as HTML. `version`, or the id of the last event: the version that it shows."""
    access, allowed = await require_watched_class(database, account, boards, class_id)
    view = OpenBoard(course, class_href(access.school_class), last_event_id or version, bool(erreurs))
    stream = _event_stream(boards.stream_view(BOARD, access.school_class.id, account.id, allowed), view)
    return StreamingResponse(stream, media_type="text/event-stream", headers=STREAM_HEADERS)


async def _event_stream(boards: AsyncIterator[Board | None], view: OpenBoard) -> AsyncIterator[str]:
    before: Board | None = None
    async for board in boards:
        yield SIGN_OF_LIFE if board is None else await run_in_threadpool(board_events, view, before, board)
        before = board or before
