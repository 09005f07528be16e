"""A gradebook as a file to download, with its HTTP headers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import date
from enum import StrEnum
from uuid import UUID

from server.marks.cells import build_xlsx, write_french_csv
from server.marks.files import (
    FormatTime,
    MoodleIdentifier,
    build_gradebook_sheets,
    build_marks_sheet,
    build_moodle_table,
    gradebook_file_name,
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
        moodle = build_moodle_table(gradebook, identifier)
        name, content = gradebook_file_name(gradebook, "moodle", "csv"), b"".join(moodle.iter_csv_lines())
        return GradebookDownload(name, content, format.media_type, {"X-Balise-Left-Out": str(len(moodle.left_out))})
    if format is GradebookFormat.xlsx:
        content = build_xlsx(build_gradebook_sheets(gradebook, format_time))
    elif format is GradebookFormat.csv:
        sheet = build_marks_sheet(gradebook)
        content = b"".join(write_french_csv(sheet.header, sheet.rows))
    else:
        content = json.dumps(gradebook_json(gradebook), default=_json_text, ensure_ascii=False, indent=1).encode()
    return GradebookDownload(gradebook_file_name(gradebook, "notes", format.value), content, format.media_type)


def _json_text(value: object) -> str:
    """Return a date or an id as text. Raise TypeError for anything else."""
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, UUID):
        return str(value)
    raise TypeError(value)
