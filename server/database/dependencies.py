"""The session of a request: committed when its function has returned, before the answer leaves."""

from collections.abc import Iterator
from typing import Annotated

from fastapi import Depends, Request
from sqlalchemy.orm import Session

from server.database.engine import Database

SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})


def get_database(request: Request) -> Database:
    database: Database = request.app.state.database
    return database


def _session(request: Request) -> Iterator[Session]:
    database = get_database(request)
    transaction = database.read() if request.method in SAFE_METHODS else database.write()
    with transaction as db:
        yield db


Db = Annotated[Session, Depends(_session, scope="function")]
DatabaseOf = Annotated[Database, Depends(get_database)]
