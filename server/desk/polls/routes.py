"""The page on which who teaches a class sees what its students expected, before they saw it."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.desk.polls.views import build_polls_page
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.forms import redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)


@router.get("/classes/{class_id}/previsions")
def show_predictions(request: Request, class_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    view = build_polls_page(reader.db, reader.course, access)
    return render_page(request, "classes/polls.html", reader.account, page=view)
