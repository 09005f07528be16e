"""Request helpers shared by the pages of a class."""

from typing import Annotated

from fastapi import Query, Request
from fastapi.responses import Response

from server.web.forms import redirect

ShortQuery = Annotated[str, Query(max_length=100)]
GroupQuery = ShortQuery
UNKNOWN_ACTION = "Cette action n’existe pas."


def redirect_to_login(request: Request) -> Response:
    return redirect(f"/connexion?suite={request.url.path}")
