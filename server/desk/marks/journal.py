"""The log of what was changed in a class, to be read, searched and taken away."""

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict
from typing import Annotated, Any
from urllib.parse import urlencode
from uuid import UUID

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response, StreamingResponse

from server.audit import repository
from server.audit import service as audit
from server.audit.models import ACTION_LABELS, AuditAction
from server.audit.schemas import AuditEntry, AuditFilter
from server.audit.wording import describe_changes
from server.classes import repository as classes
from server.classes.models import ClassRole
from server.course import Course
from server.database import utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk.asking import log_in_first
from server.desk.marks.routes import PageNumber
from server.desk.marks.schemas import Choice, EventView, LogPage
from server.desk.views import head, href_of
from server.identity.dependencies import SignedIn
from server.marks.cells import Cell, ascii_slug, french_csv
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader
from server.web.rendering import render_page
from server.web.words import iso_moment, short_moment

router = APIRouter(include_in_schema=False)

A_PAGE = 100
HEADER = ("Date", "Par", "Changement", "Élève", "Objet", "Avant et après", "Motif")
Text = Annotated[str, Query(max_length=100)]


def _wanted(student: str, kind: str) -> AuditFilter:
    """What means nothing filters nothing."""
    try:
        who = UUID(student) if student else None
    except ValueError:
        who = None
    return AuditFilter(who, AuditAction(kind) if kind in set(AuditAction) else None)


@router.get("/classes/{class_id}/journal")
def log(
    request: Request, class_id: str, reader: CurrentReader, eleve: Text = "", genre: Text = "", p: PageNumber = 1
) -> Response:
    if reader.account is None:
        return log_in_first(request)
    place = rights.require_right(reader.db, reader.account, Right.read_audit_log, class_id)
    view = _log_page(reader.db, reader.course, place, _wanted(eleve, genre), p)
    return render_page(request, "classes/log.html", reader.account, page=view)


def _log_page(db: Db, course: Course, place: ClassAccess, wanted: AuditFilter, number: int) -> LogPage:
    class_id, skipped = place.school_class.id, (number - 1) * A_PAGE
    events = repository.load_entries(db, class_id, wanted, most=A_PAGE, skipped=skipped)
    total = repository.count_entries(db, class_id, wanted)
    asked = {"eleve": str(wanted.student or ""), "genre": wanted.what or ""}
    query = {name: value for name, value in asked.items() if value}

    def address(there: int) -> str:
        return f"{href_of(place.school_class)}/journal?{urlencode({**query, 'p': there})}"

    students = [one for one in classes.load_members(db, class_id) if one.role is ClassRole.student]
    return LogPage(
        head=head(course, place, "/journal"),
        events=tuple(_view(one) for one in events),
        total=total,
        first=skipped + 1,
        students=tuple(Choice(str(one.id), one.name, one.id == wanted.student) for one in students),
        kinds=tuple(Choice(kind, words, kind == wanted.what) for kind, words in ACTION_LABELS.items()),
        newer=address(number - 1) if number > 1 else "",
        older=address(number + 1) if skipped + len(events) < total else "",
        file_query=urlencode(query),
        filtered=bool(query),
    )


def _view(one: AuditEntry) -> EventView:
    return EventView(
        at=iso_moment(one.at),
        at_text=short_moment(one.at),
        by=one.by_name,
        words=one.words,
        student=one.student_name,
        about=one.about,
        changes=describe_changes(one.before, one.after, short_moment),
        reason=one.reason,
    )


@router.get("/classes/{class_id}/journal/fichier")
def file(
    class_id: str, account: SignedIn, database: DatabaseOf, format: Text = "csv", eleve: Text = "", genre: Text = ""
) -> StreamingResponse:
    """Sent while it is read."""
    with database.read() as db:
        place = rights.require_right(db, account, Right.read_audit_log, class_id)
    events = audit.iter_entries(database, place.school_class.id, _wanted(eleve, genre))
    ending = "json" if format == "json" else "csv"
    named = f"balise-{ascii_slug(place.school_class.name, 'classe')}-journal-{utc_now():%Y-%m-%d}.{ending}"
    headers = {"Content-Disposition": f'attachment; filename="{named}"', "Cache-Control": "private, no-store"}
    if ending == "json":
        return StreamingResponse(_as_json(events), media_type="application/json", headers=headers)
    lines = french_csv(HEADER, (_line(one) for one in events))
    return StreamingResponse(lines, media_type="text/csv; charset=utf-8", headers=headers)


def _line(one: AuditEntry) -> tuple[Cell, ...]:
    view = _view(one)
    told = "\n".join(map(str, view.changes))
    return view.at_text, view.by, view.words, view.student, view.about, told, view.reason


def _as_json(events: Iterable[AuditEntry]) -> Iterator[bytes]:
    """An array, an event a line."""
    before = b"[\n"
    for one in events:
        content: dict[str, Any] = {**asdict(one), "words": one.words}
        yield before + json.dumps(content, ensure_ascii=False, default=_plain).encode()
        before = b",\n"
    yield b"[]\n" if before == b"[\n" else b"\n]\n"


def _plain(value: Any) -> str:
    return str(value) if isinstance(value, UUID) else str(value.isoformat())
