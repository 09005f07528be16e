"""The page of a class as one of its students sees it, looked at by who teaches them."""

from http import HTTPStatus

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.desk.assignments.exemption_views import find_student
from server.desk.own import views
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.forms import redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)


@router.get("/presence", status_code=HTTPStatus.NO_CONTENT)
def record_presence(_: SignedIn, reader: CurrentReader) -> Response:
    """Record that somebody who reads a page is still there, as `CurrentReader` does whenever its account is asked."""
    assert reader.account is not None  # asking for it records it
    return Response(status_code=HTTPStatus.NO_CONTENT, headers={"Cache-Control": "no-store"})


@router.get("/classes/{class_id}/eleves/{student}/comme")
def show_class_as_student(request: Request, class_id: str, student: str, reader: CurrentReader) -> Response:
    """The class as this student sees it, with nothing to press."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    member = find_student(reader.db, access, student)
    view = views.build_watched_page(reader.db, reader.course, access, reader.account, member)
    return render_page(request, "classes/own.html", reader.account, page=view)
