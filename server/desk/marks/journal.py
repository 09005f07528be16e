"""The log of changes in a class: its page and its download."""

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
from server.audit.models import ACTION_LABELS, SERVER_ACTIONS, AuditAction
from server.audit.schemas import AuditEntry, AuditFilter
from server.audit.wording import describe_changes
from server.base.bulk import OneAtATimeStream
from server.classes import repository as classes
from server.classes.models import ClassRole
from server.course import Course
from server.database import utc_now
from server.database.dependencies import DatabaseOf, Db
from server.desk.marks.schemas import GradebookOption, LogEntryView, LogPage
from server.desk.views import class_head, class_href
from server.identity.dependencies import SignedIn
from server.marks.cells import Cell, ascii_slug, write_french_csv
from server.rights import service as rights
from server.rights.models import Right
from server.rights.service import ClassAccess
from server.web.dependencies import CurrentReader, Number
from server.web.forms import redirect_to_login
from server.web.rendering import render_page
from server.web.words import format_iso_time, format_short_time

router = APIRouter(include_in_schema=False)

ENTRIES_PER_PAGE = 18
HEADER = ("Date", "Par", "Changement", "Élève", "Objet", "Avant et après", "Motif")
Text = Annotated[str, Query(max_length=100)]


def _parse_filter(student: str, kind: str) -> AuditFilter:
    """Return the filter of the fields; unknown values filter nothing."""
    try:
        student_id = UUID(student) if student else None
    except ValueError:
        student_id = None
    return AuditFilter(student_id, AuditAction(kind) if kind in set(AuditAction) else None)


@router.get("/classes/{class_id}/journal")
def show_log(
    request: Request, class_id: str, reader: CurrentReader, eleve: Text = "", genre: Text = "", p: Number = 1
) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_audit_log, class_id)
    view = _build_log_page(reader.db, reader.course, access, _parse_filter(eleve, genre), p)
    return render_page(request, "classes/log.html", reader.account, page=view)


def _build_log_page(db: Db, course: Course, access: ClassAccess, filter: AuditFilter, page_number: int) -> LogPage:
    class_id, offset = access.school_class.id, (page_number - 1) * ENTRIES_PER_PAGE
    entries = repository.load_entries(db, class_id, filter, limit=ENTRIES_PER_PAGE, offset=offset)
    total = repository.count_entries(db, class_id, filter)
    fields = {"eleve": str(filter.student or ""), "genre": filter.what or ""}
    query = {name: value for name, value in fields.items() if value}

    def address(number: int) -> str:
        return f"{class_href(access.school_class)}/journal?{urlencode({**query, 'p': number})}"

    members = classes.load_members(db, class_id)
    students = [member for member in members if member.role is ClassRole.student]
    return LogPage(
        head=class_head(course, access, "/journal"),
        entries=tuple(_entry_view(entry) for entry in entries),
        total=total,
        first=offset + 1,
        students=tuple(
            GradebookOption(str(student.id), student.name, student.id == filter.student) for student in students
        ),
        kinds=tuple(
            GradebookOption(kind, label, kind == filter.what)
            for kind, label in ACTION_LABELS.items()
            if kind not in SERVER_ACTIONS
        ),
        newer=address(page_number - 1) if page_number > 1 else "",
        older=address(page_number + 1) if offset + len(entries) < total else "",
        file_query=urlencode(query),
        filtered=bool(query),
    )


def _entry_view(entry: AuditEntry) -> LogEntryView:
    return LogEntryView(
        at=format_iso_time(entry.at),
        at_text=format_short_time(entry.at),
        by=entry.by_name,
        words=entry.words,
        student=entry.student_name,
        about=entry.about,
        changes=describe_changes(entry.before, entry.after, format_short_time),
        reason=entry.reason,
    )


@router.get("/classes/{class_id}/journal/fichier")
def download_log(
    class_id: str, account: SignedIn, database: DatabaseOf, format: Text = "csv", eleve: Text = "", genre: Text = ""
) -> StreamingResponse:
    """Stream the entries while they are read."""
    with database.read() as db:
        access = rights.require_right(db, account, Right.read_audit_log, class_id)
    entries = audit.iter_entries(database, access.school_class.id, _parse_filter(eleve, genre))
    extension = "json" if format == "json" else "csv"
    name = f"balise-{ascii_slug(access.school_class.name, 'classe')}-journal-{utc_now():%Y-%m-%d}.{extension}"
    headers = {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "private, no-store"}
    if extension == "json":
        return OneAtATimeStream(_json_lines(entries), media_type="application/json", headers=headers)
    lines = write_french_csv(HEADER, (_csv_line(entry) for entry in entries))
    return OneAtATimeStream(lines, media_type="text/csv; charset=utf-8", headers=headers)


def _csv_line(entry: AuditEntry) -> tuple[Cell, ...]:
    view = _entry_view(entry)
    changes = "\n".join(map(str, view.changes))
    return view.at_text, view.by, view.words, view.student, view.about, changes, view.reason


def _json_lines(entries: Iterable[AuditEntry]) -> Iterator[bytes]:
    """Yield a JSON array with an entry a line."""
    before = b"[\n"
    for entry in entries:
        content: dict[str, Any] = {**asdict(entry), "words": entry.words}
        yield before + json.dumps(content, ensure_ascii=False, default=_value_as_text).encode()
        before = b",\n"
    yield b"[]\n" if before == b"[\n" else b"\n]\n"


def _value_as_text(value: Any) -> str:
    return str(value) if isinstance(value, UUID) else str(value.isoformat())
