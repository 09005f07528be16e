"""A person's calendar: its secret address, and the file that other programs read there without a session."""

from typing import Annotated

from fastapi import APIRouter, Path, Request
from fastapi.responses import Response

from server.base.root_path import service_url
from server.calendars import service as calendars
from server.calendars.icalendar import MEDIA_TYPE
from server.database.dependencies import Db
from server.identity.dependencies import SignedIn
from server.web.forms import redirect
from server.web.rendering import add_etag

router = APIRouter(include_in_schema=False)

#: Programs ask again after this many seconds at the earliest, and are told whether anything has changed.
MAX_AGE = 900


@router.get("/agenda/{token}.ics")
def read_calendar(request: Request, db: Db, token: Annotated[str, Path(max_length=100)]) -> Response:
    """Return the calendar with this secret address; whoever has the address may read it."""
    owner = calendars.find_calendar_owner(db, token)
    headers = {
        "Cache-Control": f"private, max-age={MAX_AGE}",
        "Content-Disposition": 'inline; filename="balise.ics"',
        "X-Robots-Tag": "noindex",
    }
    content = calendars.build_calendar(db, owner, service_url(request))
    return add_etag(request, Response(content, headers=headers, media_type=MEDIA_TYPE))


@router.post("/compte/agenda/supprimer")
def delete_calendar_address(person: SignedIn, db: Db) -> Response:
    calendars.delete_calendar_address(db, person)
    return redirect("/compte#agenda")
