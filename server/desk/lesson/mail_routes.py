"""A teacher asks for « Après la séance » by mail, and the signed links of these mails."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Path, Request
from fastapi.responses import Response

from server.base.app_services import SettingsOf
from server.base.errors import InvalidFields, NotFound
from server.base.root_path import service_url
from server.database import roll_back_then_read, utc_now
from server.database.dependencies import DatabaseOf
from server.desk.lesson.review import review_page
from server.desk.views import class_href
from server.identity.dependencies import SignedIn, load_session_account
from server.mails import service, smtp
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.forms import UNKNOWN_ACTION, Field, redirect
from server.web.rendering import render_page

router = APIRouter(include_in_schema=False)

NOT_SET = "Ce serveur n’envoie pas de courriels : son administrateur ne l’a pas réglé."
LINK_PATH = "/courriel/{subscription_id}/{action}/{signature}"
MAX_SHOWN = 254
LINK_HEADERS = {"X-Robots-Tag": "noindex", "Referrer-Policy": "no-referrer"}
Part = Annotated[str, Path(max_length=100)]


@router.post("/classes/{class_id}/courriel")
def change_subscription(
    request: Request, class_id: str, account: SignedIn, reader: CurrentReader, settings: SettingsOf,
    action: Field = "", adresse: Field = "",
) -> Response:  # fmt: skip
    """Ask for the page by mail (`recevoir`), or stop it (`arreter`)."""
    access = rights.require_right(reader.db, account, Right.read_work, class_id)
    school_class, now = access.school_class, utc_now()
    href = f"{class_href(school_class)}/semaine"
    if action == "arreter":
        service.delete_subscription(reader.db, school_class.id, account.id)
        return redirect(f"{href}#courriel")
    if action != "recevoir":
        raise NotFound(UNKNOWN_ACTION)
    if not smtp.is_smtp_configured(settings):
        raise NotFound(NOT_SET)
    try:
        service.request_subscription(reader.db, school_class, account, adresse, service_url(request), now)
    except InvalidFields as refused:
        roll_back_then_read(reader.db)
        access = rights.require_right(reader.db, account, Right.read_work, class_id)
        view = review_page(reader.db, reader.course, access, now, None)
        mail = service.MailForm(adresse[:MAX_SHOWN], problem=refused.problems["address"])
        return render_page(request, "classes/lesson_review.html", account, status=422, page=view, mail=mail)
    return redirect(f"{href}#courriel")


@router.get(LINK_PATH)
def show_link(
    request: Request, subscription_id: Part, action: Part, signature: Part, reader: CurrentReader
) -> Response:
    """Show what the link of a mail does, with a button: a program that follows links changes nothing."""
    link = service.read_signed_link(reader.db, subscription_id, action, signature)
    return render_page(request, "mails/link.html", reader.account, headers=LINK_HEADERS, link=link)


@router.post(LINK_PATH)
def follow_link(
    request: Request, subscription_id: Part, action: Part, signature: Part, database: DatabaseOf
) -> Response:
    """Do what the link says; mail programs send this themselves to stop mails (RFC 8058)."""
    with database.write() as db:
        link = service.confirm_or_delete_subscription(db, subscription_id, action, signature, utc_now())
    account = load_session_account(request, database)
    return render_page(request, "mails/link.html", account, headers=LINK_HEADERS, link=link)
