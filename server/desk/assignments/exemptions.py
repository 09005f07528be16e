"""Pages of exemptions, and of why a date is what it is."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from server.assignments import editing, exemption_service
from server.base.errors import Forbidden, InvalidFields
from server.classes import repository as classes
from server.classes.schemas import Member
from server.course.dependencies import CourseOf
from server.database.dependencies import Db
from server.desk.asking import log_in_first
from server.desk.assignments import exemption_views
from server.desk.assignments import forms as assignment_forms
from server.desk.assignments.views import href_of
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.forms import FormFields, redirect
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

ONE = "/classes/{class_id}/devoirs/{aid}"
OTHERS = "Les dates d’un autre élève ne se lisent pas."
Word = Annotated[str, Query(max_length=100)]


@router.get(f"{ONE}/amenagements")
def exemptions(request: Request, class_id: str, aid: str, reader: CurrentReader, tri: Word = "") -> Response:
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    found = editing.find_assignment(reader.db, place.school_class, aid)
    view = exemption_views.exemptions_page(reader.db, reader.course, place, found, tri)
    return render_page(request, "classes/exemptions.html", reader.account, page=view)


@router.get(f"{ONE}/amenagements.csv")
def export(request: Request, class_id: str, aid: str, reader: CurrentReader, tri: Word = "") -> Response:
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    found = editing.find_assignment(reader.db, place.school_class, aid)
    headers = {"Content-Disposition": 'attachment; filename="amenagements.csv"', "Cache-Control": "private, no-store"}
    content = exemption_views.as_csv(reader.db, place, found, tri)
    return Response(content, media_type="text/csv; charset=utf-8", headers=headers)


@router.post(f"{ONE}/amenagements")
def grant(
    request: Request, class_id: str, aid: str, account: SignedIn, db: Db, course: CourseOf, fields: FormFields
) -> Response:
    place = rights.require_right(db, account, Right.manage_assignments, class_id)
    found = editing.find_assignment(db, place.school_class, aid, to_change=True)
    values = assignment_forms.exemption_values(fields)
    try:
        whom, wanted = assignment_forms.exemption(fields)
        members = classes.load_members(db, place.school_class.id)
        exemption_service.grant_exemptions(
            db, place.school_class, account.id, found, members, whom, wanted, replacing=values.replace
        )
    except InvalidFields as refused:
        view = exemption_views.exemptions_page(db, course, place, found, "", values, refused.problems)
        return render_page(request, "classes/exemptions.html", account, status=422, page=view)
    return redirect(f"{href_of(found)}/amenagements")


@router.post(f"{ONE}/amenagements/{{eid}}/retirer")
def revoke(class_id: str, aid: str, eid: str, account: SignedIn, db: Db) -> Response:
    place = rights.require_right(db, account, Right.manage_assignments, class_id)
    found = editing.find_assignment(db, place.school_class, aid, to_change=True)
    exemption_service.revoke_exemption(
        db, place.school_class, account.id, found, exemption_service.find_exemption(db, found, eid)
    )
    return redirect(f"{href_of(found)}/amenagements")


@router.get(f"{ONE}/pourquoi")
def why(request: Request, class_id: str, aid: str, reader: CurrentReader, eleve: Word = "") -> Response:
    """Of the first of the class, where its staff name nobody; of oneself, for a student."""
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.see_assignments, class_id)
    found = editing.find_assignment(reader.db, place.school_class, aid)
    if not place.has(Right.see_students):
        assert place.membership is not None  # who has no seat is an administrator
        if eleve and eleve.lower() != str(reader.account.id):
            raise Forbidden(OTHERS)
        student = Member(place.membership, reader.account)
    else:
        student = exemption_views.find_student(reader.db, place, eleve)
    view = exemption_views.why_page(reader.db, reader.course, place, found, student)
    return render_page(request, "classes/why.html", reader.account, page=view)
