"""Pages of exemptions, and of why a date is what it is."""

from __future__ import annotations

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.assignments import editing, exemption_service
from server.base.errors import Forbidden, InvalidFields
from server.classes import repository as classes
from server.classes.schemas import Member
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read
from server.database.dependencies import Db
from server.desk.assignments import exemption_views
from server.desk.assignments import forms as assignment_forms
from server.desk.assignments.views import assignment_href
from server.desk.requests import ShortQuery
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.form_version import VERSION_FIELD, require_form_version
from server.web.forms import FormFields, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

ASSIGNMENT_PATH = "/classes/{class_id}/devoirs/{aid}"
OTHER_STUDENT_FORBIDDEN = "Les dates d’un autre élève ne se lisent pas."
EXEMPTIONS_CHANGED = (
    "Les aménagements de ce devoir ont changé depuis que cette page est ouverte : regardez d’abord ce qui est accordé. "
    "Rien de votre saisie n’est encore enregistré."
)
GRANT_ANYWAY = "Accorder quand même"


@router.get(f"{ASSIGNMENT_PATH}/amenagements")
def show_exemptions(request: Request, class_id: str, aid: str, reader: CurrentReader, tri: ShortQuery = "") -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    found = editing.find_assignment(reader.db, access.school_class, aid)
    view = exemption_views.build_exemptions_page(reader.db, reader.course, access, found, tri)
    return render_page(request, "classes/exemptions.html", reader.account, page=view)


@router.get(f"{ASSIGNMENT_PATH}/amenagements.csv")
def export_exemptions(
    request: Request, class_id: str, aid: str, reader: CurrentReader, tri: ShortQuery = ""
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_students, class_id)
    found = editing.find_assignment(reader.db, access.school_class, aid)
    headers = {"Content-Disposition": 'attachment; filename="amenagements.csv"', "Cache-Control": "private, no-store"}
    content = exemption_views.exemptions_csv(reader.db, access, found, tri)
    return Response(content, media_type="text/csv; charset=utf-8", headers=headers)


@router.post(f"{ASSIGNMENT_PATH}/amenagements")
def grant_exemption(
    request: Request, class_id: str, aid: str, account: SignedIn, db: Db, course: CourseOf, fields: FormFields
) -> Response:
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    found = editing.find_assignment(db, access.school_class, aid, to_change=True)
    values = assignment_forms.submitted_exemption_values(fields)
    try:
        whom, wanted = assignment_forms.parse_exemption(fields)
        version = exemption_views.exemptions_version(db, found)
        require_form_version(fields, account, version, EXEMPTIONS_CHANGED, GRANT_ANYWAY)
        members = classes.load_members(db, access.school_class.id)
        exemption_service.grant_exemptions(
            db, access.school_class, account.id, found, members, whom, wanted, replacing=values.replace
        )
    except InvalidFields as refused:
        roll_back_then_read(db)
        version = assignment_forms.field_text(fields, VERSION_FIELD)
        view = exemption_views.build_exemptions_page(db, course, access, found, "", values, refused.problems, version)
        return render_page(request, "classes/exemptions.html", account, status=422, page=view)
    return redirect(f"{assignment_href(found)}/amenagements")


@router.post(f"{ASSIGNMENT_PATH}/amenagements/{{eid}}/retirer")
def revoke_exemption(class_id: str, aid: str, eid: str, account: SignedIn, db: Db) -> Response:
    access = rights.require_right(db, account, Right.manage_assignments, class_id)
    found = editing.find_assignment(db, access.school_class, aid, to_change=True)
    exemption_service.revoke_exemption(
        db, access.school_class, account.id, found, exemption_service.find_exemption(db, found, eid)
    )
    return redirect(f"{assignment_href(found)}/amenagements")


@router.get(f"{ASSIGNMENT_PATH}/pourquoi")
def explain_rules(request: Request, class_id: str, aid: str, reader: CurrentReader, eleve: ShortQuery = "") -> Response:
    """Of the first of the class, where its staff name nobody; of oneself, for a student."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_assignments, class_id)
    found = editing.find_assignment(reader.db, access.school_class, aid)
    if not access.has(Right.see_students):
        assert access.membership is not None  # who has no seat is an administrator
        if eleve and eleve.lower() != str(reader.account.id):
            raise Forbidden(OTHER_STUDENT_FORBIDDEN)
        student = Member(access.membership, reader.account)
    else:
        student = exemption_views.find_student(reader.db, access, eleve)
    view = exemption_views.build_rules_explanation_page(reader.db, reader.course, access, found, student)
    return render_page(request, "classes/why.html", reader.account, page=view)
