"""Request dependencies of every room with pages: the module of the address, the reader, the number of a page."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Query, Request
from starlette.convertors import Convertor, register_url_convertor

from server.base.app_services import app_service_getter
from server.base.http import SAFE_METHODS
from server.classes.presence import PresenceRecorder
from server.course import Course
from server.course.editions import MODULE
from server.database import Database
from server.database.dependencies import Db
from server.identity.dependencies import load_session_account, load_session_account_in
from server.identity.models import Account
from server.submissions.service import SubmissionService
from server.web.views import Reader

_database, _course, _submissions, _presence = (
    app_service_getter(Database),
    app_service_getter(Course),
    app_service_getter(SubmissionService),
    app_service_getter(PresenceRecorder),
)


class ModuleConvertor(Convertor[str]):
    """A module's slug, so that `/l20` never stands in the way of `/connexion`."""

    regex = MODULE

    def convert(self, value: str) -> str:
        return value

    def to_string(self, value: str) -> str:
        return value


register_url_convertor("module", ModuleConvertor())


async def _build_reader(request: Request, db: Db) -> Reader:
    def who() -> Account | None:
        if request.method not in SAFE_METHODS:
            return load_session_account(request, _database(request.app))
        account = load_session_account_in(db, request)  # it only reads
        _presence(request.app).record(db, account)
        return account

    return Reader(db, _course(request.app), _submissions(request.app), who)


CurrentReader = Annotated[Reader, Depends(_build_reader)]
#: No list has a million pages, no exercise a million attempts, no file a million lines.
MAX_NUMBER = 10**6
#: A number in an address, counted from one, under the name of its parameter.
Number = Annotated[int, Query(ge=1, le=MAX_NUMBER)]
#: Of a list in pages, as `?page=2`.
PageNumber = Annotated[int, Query(alias="page", ge=1, le=MAX_NUMBER)]
