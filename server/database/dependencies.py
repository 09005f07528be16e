"""The session of a request: committed when its function has returned, before the answer leaves."""

from collections.abc import AsyncIterator
from typing import Annotated

from anyio import CancelScope, CapacityLimiter
from anyio.to_thread import run_sync
from fastapi import Depends, Request
from fastapi.concurrency import contextmanager_in_threadpool
from sqlalchemy.orm import Session

from server.base.app_services import app_service, app_service_getter
from server.base.http import SAFE_METHODS
from server.database.engine import Database

DatabaseOf = Annotated[Database, Depends(app_service(Database))]


_database = app_service_getter(Database)


async def _open_request_session(request: Request) -> AsyncIterator[Session]:
    """Crossing to a thread and back costs more than a statement: a session that only reads says nothing to the database
    before the request's function does, and leaving a file is no wait."""
    database = _database(request.app)
    if request.method not in SAFE_METHODS:
        async with contextmanager_in_threadpool(database.write()) as db:
            yield db
        return
    db = database.open_read_session()
    try:
        yield db
    finally:
        if database.is_local_file or not db.in_transaction():
            db.close()
        else:
            await _close_session_in_thread(db)


async def _close_session_in_thread(db: Session) -> None:
    """In a thread beside those that answer: these may all be waiting for the connection that it gives back."""
    with CancelScope(shield=True):
        await run_sync(db.close, limiter=CapacityLimiter(1))


Db = Annotated[Session, Depends(_open_request_session, scope="function")]
