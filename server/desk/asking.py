"""What the pages of a class share of a request."""

from typing import Annotated

from fastapi import Query, Request
from fastapi.responses import Response

from server.web.forms import redirect

Group = Annotated[str, Query(max_length=100)]
UNKNOWN_ACTION = "Cette action n’existe pas."


def log_in_first(request: Request) -> Response:
    return redirect(f"/connexion?suite={request.url.path}")
