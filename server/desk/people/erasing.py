"""The page by which a teacher, or an administrator, erases a student on request."""

from uuid import UUID

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse, Response

from server.base.app_services import SettingsOf
from server.base.errors import NotFound
from server.base.settings import Settings
from server.course.dependencies import CourseOf
from server.database import roll_back_then_read, utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk import views
from server.identity.dependencies import SignedIn
from server.identity.models import Account
from server.personal import erasures
from server.personal.dependencies import PersonalDataOf
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader
from server.web.forms import UNKNOWN_ACTION, Field, redirect, redirect_to_login
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

PATH = "/classes/{class_id}/eleves/{student}/effacer"


@router.get(PATH)
def show_preview(
    request: Request, class_id: str, student: UUID, reader: CurrentReader, settings: SettingsOf
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.erase_students, class_id)
    return _render_erasure_preview(request, reader.db, reader.course, settings, reader.account, access, student)


def _render_erasure_preview(
    request: Request, db: Db, course: CourseOf, settings: Settings, account: Account, access: ClassAccess,
    student: UUID, changed: bool = False,
) -> HTMLResponse:  # fmt: skip
    now = utc_now()
    person = erasures.find_present_or_former_student(db, access.school_class.id, student)
    preview = erasures.preview_erasure_by_staff(db, account, access.school_class.id, person, now)
    scope = access.school_class.id if preview.class_only else None
    standing = erasures.find_pending_erasure(db, person.id, scope, settings, now)
    head = views.class_head(course, access, "/eleves")
    return render_page(
        request,
        "classes/erase.html",
        account,
        status=409 if changed else 200,
        head=head,
        preview=preview,
        standing=standing,
        days=settings.erasure_days,
        changed=changed,
        action=f"{head.href}/eleves/{student}/effacer",
    )


@router.post(PATH)
def erase_student(
    request: Request, class_id: str, student: UUID, account: SignedIn, database: DatabaseOf, course: CourseOf,
    personal: PersonalDataOf, settings: SettingsOf, action: Field = "effacer", attendu: Field = "",
) -> Response:  # fmt: skip
    """Erases what the page has shown, whose digest is `attendu`; else shows it again. With `annuler`, cancels."""
    if action not in {"effacer", "annuler"}:
        raise NotFound(UNKNOWN_ACTION)
    with database.write() as db:
        access = rights.require_right(db, account, Right.erase_students, class_id)
        school_class = access.school_class
        person = erasures.find_present_or_former_student(db, school_class.id, student)
        preview = erasures.preview_erasure_by_staff(db, account, school_class.id, person, utc_now())
        scope = school_class.id if preview.class_only else None
        address = f"{views.class_href(school_class)}/eleves"
        if action == "annuler":
            erasures.cancel_erasure(db, person, scope, account)
            return redirect(f"{address}/{student}/effacer")
        if attendu != preview.digest:
            roll_back_then_read(db)
            return _render_erasure_preview(
                request, db, course, settings, account, access, student, changed=bool(attendu)
            )
    done = personal.erase_on_request(student, by=account.id, class_id=scope)
    return redirect(address if done else f"{address}/{student}/effacer")
