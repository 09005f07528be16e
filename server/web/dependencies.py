"""What every room with pages asks of a request: the module in its address, and who looks."""

from __future__ import annotations

from typing import Annotated

from fastapi import Depends, Request
from starlette.convertors import Convertor, register_url_convertor

from server.base.request import SAFE_METHODS
from server.classes.dependencies import PresenceOf
from server.course.dependencies import CourseOf
from server.course.editions import MODULE
from server.database.dependencies import DatabaseOf, Db
from server.identity.dependencies import account_of
from server.identity.models import Account
from server.submissions.dependencies import SubmissionsOf
from server.web.views import Reader


class ModuleConvertor(Convertor[str]):
    """A module's slug, so that `/l20` never stands in the way of `/connexion`."""

    regex = MODULE

    def convert(self, value: str) -> str:
        return value

    def to_string(self, value: str) -> str:
        return value


register_url_convertor("module", ModuleConvertor())


async def _reader(
    request: Request,
    db: Db,
    database: DatabaseOf,
    course: CourseOf,
    submissions: SubmissionsOf,
    presence: PresenceOf,
) -> Reader:
    def who() -> Account | None:
        account = account_of(request, database)
        if request.method in SAFE_METHODS:  # `db` only reads
            presence.note(db, account)
        return account

    return Reader(db, course, submissions, who)


Reading = Annotated[Reader, Depends(_reader)]
