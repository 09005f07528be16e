"""The log of administrators' actions, for administrators."""

from datetime import timedelta
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import Response

from server.audit import repository
from server.audit.wording import describe_changes
from server.base.errors import Forbidden
from server.database import utc_now
from server.mails import repository as mails
from server.web.dependencies import CurrentReader, PageNumber
from server.web.forms import redirect_to_login
from server.web.rendering import render_page
from server.web.words import format_short_time

router = APIRouter(include_in_schema=False)

LOG_PATH = "/administration/journal"
ENTRIES_PER_PAGE = 30
MAIL_DAYS, SHOWN_PROBLEMS = 7, 5
ADMINISTRATORS = "Ce journal est celui des administrateurs de ce serveur."


@router.get(LOG_PATH)
def show_audit_log(request: Request, reader: CurrentReader, number: PageNumber = 1) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    if not reader.account.is_administrator:
        raise Forbidden(ADMINISTRATORS)
    skipped = (number - 1) * ENTRIES_PER_PAGE
    entries = repository.load_server_entries(reader.db, limit=ENTRIES_PER_PAGE + 1, offset=skipped)
    now = utc_now()
    page: dict[str, Any] = {
        "mail_problems": mails.load_delivery_problems(reader.db, now - timedelta(days=MAIL_DAYS), SHOWN_PROBLEMS),
        "entries": [
            (entry, describe_changes(entry.before, entry.after, format_short_time))
            for entry in entries[:ENTRIES_PER_PAGE]
        ],
        "path": LOG_PATH,
        "number": number,
        "more": len(entries) > ENTRIES_PER_PAGE,
    }
    return render_page(request, "administration/log.html", reader.account, page=page)
