"""Streams of the parts of a page, as HTML, to the script that puts them in place (`lesson.js`)."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Callable, Mapping
from functools import partial
from typing import TypeVar

from starlette.concurrency import run_in_threadpool

from server.base import root_path
from server.board.live import LiveClassViews
from server.board.service import may_watch_board
from server.database import Database
from server.identity.models import Account
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.submissions.job_events import format_sse

SIGN_OF_LIFE = ":\n\n"
ENDED = "ended"

ShownType = TypeVar("ShownType")


async def require_watched_class(
    database: Database, account: Account, boards: LiveClassViews, class_id: str
) -> tuple[ClassAccess, Callable[[], bool]]:
    """Return the class that a teacher watches, and whether they still may. Refusals come before the stream begins."""
    access = await run_in_threadpool(_require_access, database, account, class_id)
    boards.require_free_stream(account.id)
    return access, partial(_may_watch, database, account, access)


def _require_access(database: Database, account: Account, class_id: str) -> ClassAccess:
    with database.read() as db:
        return rights.require_right(db, account, Right.read_work, class_id)


def _may_watch(database: Database, account: Account, access: ClassAccess) -> bool:
    with database.read() as db:
        return may_watch_board(db, account.id, access.school_class.id)


async def stream_parts(
    readings: AsyncIterator[ShownType | None], render: Callable[[ShownType], Mapping[str, str] | None]
) -> AsyncIterator[str]:
    """Send the parts that have changed since they were sent; the end once `render` returns None."""
    sent: Mapping[str, str] = {}
    async for shown in readings:
        if shown is None:
            yield SIGN_OF_LIFE
            continue
        parts = render(shown)
        if parts is None:
            yield format_sse(ENDED, "")
            return
        changed = {name: root_path.with_external_paths(html) for name, html in parts.items() if sent.get(name) != html}
        sent = parts
        yield format_sse("parts", json.dumps(changed)) if changed else SIGN_OF_LIFE
