"""The pages of objectives: of a class, of a student, for the conseil de classe; the mistakes of a class as a file."""

from __future__ import annotations

from datetime import date, datetime, time, timedelta
from enum import StrEnum
from typing import Annotated
from uuid import UUID

from fastapi import APIRouter, Query, Request
from fastapi.responses import Response

from server.base import school_time
from server.base.errors import Invalid
from server.board.mistake_files import build_mistake_workbook, build_mistakes_sheet
from server.classes import repository as classes
from server.course.dependencies import CourseOf
from server.database import utc_now
from server.database.dependencies import Db
from server.desk.objectives import views
from server.desk.objectives.council import build_council_page
from server.desk.requests import ShortQuery
from server.desk.talk.work_views import find_student_work
from server.identity.dependencies import SignedIn
from server.marks.cells import ascii_slug, build_xlsx, write_french_csv
from server.marks.downloads import CSV, GradebookDownload, GradebookFormat
from server.rights import service as rights
from server.rights.models import Right
from server.web.dependencies import CurrentReader
from server.web.forms import redirect_to_login
from server.web.rendering import render_page
from server.web.words import format_short_time

router = APIRouter(include_in_schema=False)

#: The period of a sheet for the conseil de classe, where no date is chosen.
TERM = timedelta(weeks=13)
NO_DATE = "« {text} » n’est pas une date : écrivez-la comme 2026-09-01."


class MistakeFormat(StrEnum):
    """The file formats of the mistakes of a class."""

    csv = "csv"
    xlsx = "xlsx"


@router.get("/classes/{class_id}/objectifs")
def show_objectives(request: Request, class_id: str, reader: CurrentReader) -> Response:
    """The objectives of the class for its staff; for a student, their own."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.see_class, class_id)
    if access.has(Right.read_work):
        view = views.build_class_page(reader.db, reader.course, access, utc_now())
        return render_page(request, "classes/objectives.html", reader.account, page=view)
    access = rights.require_right(reader.db, reader.account, Right.see_assignments, class_id)
    own = views.build_student_page(
        reader.db, reader.course, access, reader.account.id, reader.account.name or "", utc_now(), is_own=True
    )
    return render_page(request, "classes/student_objectives.html", reader.account, page=own)


@router.get("/classes/{class_id}/eleves/{student}/objectifs")
def show_student_objectives(request: Request, class_id: str, student: UUID, reader: CurrentReader) -> Response:
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    work = find_student_work(reader, access, student)
    view = views.build_student_page(
        reader.db,
        reader.course,
        access,
        student,
        work.name,
        utc_now(),
        is_own=False,
        until=work.until,
        gone=work.gone,
    )
    return render_page(request, "classes/student_objectives.html", reader.account, page=view)


@router.get("/classes/{class_id}/conseil")
def show_council_sheet(request: Request, class_id: str, reader: CurrentReader, depuis: ShortQuery = "") -> Response:
    """A line or two of each student, to print; `depuis`: the first day of the period."""
    if reader.account is None:
        return redirect_to_login(request)
    access = rights.require_right(reader.db, reader.account, Right.read_work, class_id)
    now = utc_now()
    view = build_council_page(reader.db, reader.course, access, now, _parse_day(depuis) or now - TERM)
    return render_page(request, "classes/council.html", reader.account, page=view)


def _parse_day(text: str) -> datetime | None:
    """Return the begin of a day on the school's clock; None for no text. Raise Invalid."""
    if not text:
        return None
    try:
        day = date.fromisoformat(text)
    except ValueError:
        raise Invalid(NO_DATE.format(text=text)) from None
    if day.year not in school_time.YEARS:
        raise Invalid(NO_DATE.format(text=text))
    return datetime.combine(day, time(), school_time.time_zone())


@router.get("/classes/{class_id}/erreurs/fichier")
def download_mistakes(
    class_id: str,
    account: SignedIn,
    db: Db,
    course: CourseOf,
    format: Annotated[MistakeFormat, Query()] = MistakeFormat.xlsx,
) -> Response:
    """The mistakes of each student, and where they stand in the objectives."""
    access = rights.require_right(db, account, Right.read_work, class_id)
    loaded = views.load_class_objectives(db, course, access.school_class, utc_now())
    students = classes.load_student_records(db, access.school_class.id)
    if format is MistakeFormat.csv:
        sheet = build_mistakes_sheet(loaded, students, format_short_time)
        content, media_type = b"".join(write_french_csv(sheet.header, sheet.rows)), CSV
    else:
        content = build_xlsx(build_mistake_workbook(loaded, students, format_short_time))
        media_type = GradebookFormat.xlsx.media_type
    slug = ascii_slug(access.school_class.name, "classe")
    name = f"balise-{slug}-erreurs-{loaded.progress.now:%Y-%m-%d}.{format.value}"
    rendered = GradebookDownload(name, content, media_type)
    return Response(rendered.content, media_type=rendered.media_type, headers=rendered.headers)
