"""The page of a class on the courses of a platform that are tied to it: marks that are sent there, and untying."""

from __future__ import annotations

from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import Response
from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Invalid, NotFound
from server.base.validation import parse_uuid
from server.classes.models import SchoolClass
from server.database import utc_now
from server.database.dependencies import DatabaseOf
from server.desk.school.views import build_school_page
from server.federation import contexts, outbox_repository, repository
from server.federation.models import ProviderContext
from server.identity.dependencies import SignedIn
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

SCHOOL_PATH = "/classes/{class_id}/plateforme"
UNKNOWN_ASSIGNMENT = "Ce devoir n’existe pas, ou a été supprimé."


@router.get(SCHOOL_PATH)
def show_courses(request: Request, class_id: str, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.configure_class, class_id)
    view = build_school_page(reader.db, reader.course, access)
    return render_page(request, "classes/school.html", reader.account, page=view)


@router.post(SCHOOL_PATH)
def change_courses(
    class_id: str,
    account: SignedIn,
    database: DatabaseOf,
    cours: Field = "",
    action: Field = "",
    devoir: Field = "",
    eleve: Field = "",
) -> Response:
    """`envoyer` and `arreter` the marks of an assignment; `renvoyer` those refused, or one student's; `delier`."""
    with database.write() as db:
        access = rights.require_right(db, account, Right.configure_class, class_id)
        school_class = access.school_class
        context = find_context(db, school_class, cours)
        if action == "delier":
            contexts.unlink_class(db, context, school_class, account.id)
        elif action == "envoyer":
            outbox_repository.add_line_item(db, context.id, _find_assignment(db, school_class, devoir), utc_now())
        elif action == "arreter":
            outbox_repository.remove_line_item(db, context.id, _find_assignment(db, school_class, devoir))
        elif action == "renvoyer":
            _send_again(db, school_class, context, account.id, devoir, eleve)
        else:
            raise Invalid(UNKNOWN_ACTION)
    return redirect(SCHOOL_PATH.format(class_id=class_id))


def find_context(db: Session, school_class: SchoolClass, name: str) -> ProviderContext:
    """Raises NotFound."""
    context = repository.find_context(db, parse_uuid(name, contexts.UNKNOWN))
    if context is None or context.class_id != school_class.id:
        raise NotFound(contexts.UNKNOWN)
    return context


def _find_assignment(db: Session, school_class: SchoolClass, name: str) -> UUID:
    """Raises NotFound."""
    assignment_id = parse_uuid(name, UNKNOWN_ASSIGNMENT)
    if assignment_id not in {row.id for row in assignments.load_class_assignments(db, school_class.id)}:
        raise NotFound(UNKNOWN_ASSIGNMENT)
    return assignment_id


def _send_again(
    db: Session, school_class: SchoolClass, context: ProviderContext, by: UUID, assignment: str, student: str
) -> None:
    """Have the refused marks of an assignment sent again, or the mark of one student whatever its state."""
    item = outbox_repository.find_line_item(db, context.id, _find_assignment(db, school_class, assignment))
    if item is None:
        raise NotFound(UNKNOWN_ASSIGNMENT)
    only = parse_uuid(student, "Cet élève n’existe pas.") if student else None
    outbox_repository.requeue_deliveries(db, [item.id], only, utc_now())
    audit.record_event(db, school_class.id, by, AuditAction.marks_resent, student=only, about=context.title)
