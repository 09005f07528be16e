"""The page of a class as one of its students sees it, looked at by who teaches them."""

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.desk.asking import log_in_first
from server.desk.assignments.exemption_views import find_student
from server.desk.own import views
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)


@router.get("/classes/{class_id}/eleves/{student}/comme")
def as_student(request: Request, class_id: str, student: str, reader: CurrentReader) -> Response:
    """The class as this student sees it, with nothing to press."""
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    member = find_student(reader.db, place, student)
    view = views.watched_page(reader.db, reader.course, place, reader.account, member)
    return render_page(request, "classes/own.html", reader.account, page=view)
