"""A gradebook as a file to download, with its HTTP headers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date
from enum import StrEnum
from uuid import UUID

from server.marks.cells import french_csv, xlsx
from server.marks.files import (
    FormatTime,
    MoodleIdentifier,
    file_name,
    gradebook_sheets,
    marks_sheet,
    moodle_file,
)
from server.marks.plain_values import gradebook_json
from server.marks.schemas import Gradebook

CSV = "text/csv; charset=utf-8"


class GradebookFormat(StrEnum):
    """The file formats of a gradebook."""

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
    extra_headers: Mapping[str, str] = field(default_factory=dict)

    @property
    def headers(self) -> dict[str, str]:
        common = {"Content-Disposition": f'attachment; filename="{self.name}"', "Cache-Control": "private, no-store"}
        return {**common, **self.extra_headers}


def render_download(
    gradebook: Gradebook, format: GradebookFormat, identifier: MoodleIdentifier, format_time: FormatTime
) -> GradebookDownload:
    """Render a file. `identifier` is for Moodle's, whose header `X-Balise-Left-Out` counts the students left out."""
    if format is GradebookFormat.moodle:
        moodle = moodle_file(gradebook, identifier)
        name, content = file_name(gradebook, "moodle", "csv"), b"".join(moodle.lines())
        return GradebookDownload(name, content, format.media_type, {"X-Balise-Left-Out": str(len(moodle.left_out))})
    if format is GradebookFormat.xlsx:
        content = xlsx(gradebook_sheets(gradebook, format_time))
    elif format is GradebookFormat.csv:
        sheet = marks_sheet(gradebook)
        content = b"".join(french_csv(sheet.header, sheet.rows))
    else:
        content = json.dumps(gradebook_json(gradebook), default=_text_of, ensure_ascii=False, indent=1).encode()
    return GradebookDownload(file_name(gradebook, "notes", format.value), content, format.media_type)


def _text_of(value: object) -> str:
    """Return a date or an id as text. Raise TypeError for anything else."""
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, UUID):
        return str(value)
    raise TypeError(value)
