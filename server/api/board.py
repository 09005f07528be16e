"""The board of a class, and what changes on it."""

import json
from collections.abc import AsyncIterator
from dataclasses import asdict
from functools import partial
from typing import Any

from fastapi import APIRouter
from fastapi.responses import Response, StreamingResponse
from starlette.concurrency import run_in_threadpool

from server.api.board_schemas import DashboardOut
from server.api.documentation import event_stream_response, problem_responses
from server.board import service
from server.board.dependencies import LiveBoardsOf
from server.board.live import BOARD
from server.board.schemas import Board, BoardStatistics, ProgressCell
from server.course.dependencies import CourseOf
from server.database import Database, utc_now
from server.database.dependencies import DatabaseOf, Db
from server.identity.dependencies import ApiAccount
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.submissions.job_events import STREAM_HEADERS, format_sse

router = APIRouter(tags=["classes"])

STREAM = event_stream_response(
    "`counts` at first; then `cell` and `counts`, as in the dashboard, each time that one changes.", "cell"
)
SIGN_OF_LIFE = ":\n\n"


@router.get("/classes/{class_id}/dashboard", response_model=DashboardOut, responses=problem_responses(401, 403, 404))
def dashboard(class_id: str, account: ApiAccount, course: CourseOf, db: Db) -> Response:
    """The figures behind the class's page, for who teaches or helps there."""
    place = rights.require_right(db, account, Right.read_work, class_id)
    shown, insights = service.load_board_and_statistics(db, course, place.school_class, utc_now())
    return Response(_json_text(_dashboard_members(shown, insights)), media_type="application/json")


def _json_text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)


def _dashboard_members(shown: Board, insights: BoardStatistics) -> dict[str, Any]:
    return {
        "class": str(shown.class_id),
        "generated_at": shown.generated_at.isoformat(),
        "counts": asdict(shown.counts),
        "misconceptions": [
            {
                "exercise": misconception.exercise,
                "id": misconception.id,
                "title": misconception.title,
                "now": misconception.now,
                "ever": misconception.ever,
                "overcome": misconception.overcome,
                "median_attempts": misconception.median_attempts,
                "students": [str(student) for student in misconception.students],
            }
            for misconception in shown.misconceptions
        ],
        "cells": [cell_json(cell) for cell in shown.cells_by_pair.values()],
        "unnamed": [
            {
                "exercise": failure.exercise,
                "group": failure.group,
                "students": [str(student) for student in failure.students],
                "submission": str(failure.submission),
            }
            for failure in insights.unnamed
        ],
        "items": [
            {
                "exercise": item.exercise,
                "success": item.success,
                "median_attempts": item.median_attempts,
                "discrimination": item.discrimination,
                "n": item.n,
            }
            for item in insights.items
        ],
    }


def cell_json(cell: ProgressCell) -> dict[str, Any]:
    return {
        "student": str(cell.student),
        "exercise": cell.exercise,
        "points": cell.points,
        "attempts": cell.attempts,
        "state": cell.state.value,
        "misconception": cell.misconception,
    }


@router.get(
    "/classes/{class_id}/events",
    response_class=Response,
    responses={200: STREAM, **problem_responses(401, 403, 404, 429)},
)
async def follow(class_id: str, account: ApiAccount, database: DatabaseOf, boards: LiveBoardsOf) -> Response:
    """What changes on the board, as server-sent events. Ends after some minutes: come back, or when one may not see it
    any more."""
    place = await run_in_threadpool(
        _require_read_work, database, account, class_id
    )  # refusals come before the stream begins
    boards.require_free_stream(account.id)
    allowed = partial(_may_still_watch, database, account, place)
    stream = _iter_board_events(boards.stream_view(BOARD, place.school_class.id, account.id, allowed))
    return StreamingResponse(stream, headers=STREAM_HEADERS, media_type="text/event-stream")


def _require_read_work(database: Database, account: Account, class_id: str) -> ClassAccess:
    with database.read() as db:
        return rights.require_right(db, account, Right.read_work, class_id)


def _may_still_watch(database: Database, account: Account, place: ClassAccess) -> bool:
    with database.read() as db:
        return service.may_watch_board(db, account.id, place.school_class.id)


async def _iter_board_events(boards: AsyncIterator[Board | None]) -> AsyncIterator[str]:
    before: Board | None = None
    async for shown in boards:
        yield SIGN_OF_LIFE if shown is None else format_board_changes(before, shown)
        before = shown or before


def format_board_changes(before: Board | None, shown: Board) -> str:
    """As events; `counts` alone where there was nothing before."""
    told = []
    if before is not None:
        told = [format_sse("cell", _json_text(cell_json(cell))) for cell in shown.cells_changed_since(before)]
    if before is None or before.counts != shown.counts:
        told.append(format_sse("counts", _json_text(asdict(shown.counts))))
    return "".join(told) or SIGN_OF_LIFE
