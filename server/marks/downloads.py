"""A book as one file that is taken away, with the headers that it is sent with."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from uuid import UUID

from server.marks.cells import french_csv, xlsx
from server.marks.files import (
    FormatTime,
    MoodleIdentifier,
    file_name,
    gradebook_json,
    gradebook_sheets,
    marks_sheet,
    moodle_file,
)
from server.marks.schemas import Gradebook

CSV = "text/csv; charset=utf-8"


class GradebookFormat(StrEnum):
    """What a gradebook may be taken away as."""

    json = "json"
    csv = "csv"
    xlsx = "xlsx"
    moodle = "moodle"

    @property
    def media_type(self) -> str:
        return {
            GradebookFormat.json: "application/json",
            GradebookFormat.xlsx: "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
        }.get(self, CSV)


@dataclass(frozen=True)
class GradebookDownload:
    name: str
    content: bytes
    media_type: str
    more: Mapping[str, str] = field(default_factory=dict)

    @property
    def headers(self) -> dict[str, str]:
        kept = {"Content-Disposition": f'attachment; filename="{self.name}"', "Cache-Control": "private, no-store"}
        return {**kept, **self.more}


def render_download(
    book: Gradebook, format: GradebookFormat, identifier: MoodleIdentifier, when: FormatTime
) -> GradebookDownload:
    """`identifier` is for Moodle's file alone: `X-Balise-Left-Out` says how many students it is without."""
    kind = format.media_type
    if format is GradebookFormat.xlsx:
        return GradebookDownload(file_name(book, "notes", "xlsx"), xlsx(gradebook_sheets(book, when)), kind)
    if format is GradebookFormat.csv:
        sheet = marks_sheet(book)
        return GradebookDownload(file_name(book, "notes", "csv"), b"".join(french_csv(sheet.header, sheet.rows)), kind)
    if format is GradebookFormat.moodle:
        made = moodle_file(book, identifier)
        left_out = {"X-Balise-Left-Out": str(len(made.left_out))}
        return GradebookDownload(file_name(book, "moodle", "csv"), b"".join(made.pieces()), kind, left_out)
    content = json.dumps(gradebook_json(book), default=_plain, ensure_ascii=False, indent=1)
    return GradebookDownload(file_name(book, "notes", "json"), content.encode(), kind)


def _plain(value: object) -> str:
    """Raises TypeError for what is neither a date nor a name."""
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, UUID):
        return str(value)
    raise TypeError(value)
