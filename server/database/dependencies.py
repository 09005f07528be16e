"""The session of a request: committed when its function has returned, before the answer leaves."""

from collections.abc import Iterator
from typing import Annotated

from fastapi import Depends, Request
from sqlalchemy.orm import Session

from server.base.provided import provided
from server.base.request import SAFE_METHODS
from server.database.engine import Database

DatabaseOf = Annotated[Database, Depends(provided(Database))]


def _session(request: Request, database: DatabaseOf) -> Iterator[Session]:
    transaction = database.read() if request.method in SAFE_METHODS else database.write()
    with transaction as db:
        yield db


Db = Annotated[Session, Depends(_session, scope="function")]
