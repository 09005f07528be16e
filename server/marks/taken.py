"""A book as one file that is taken away, with the headers that it is sent with."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from uuid import UUID

from server.marks.cells import french_csv, xlsx
from server.marks.files import Identifier, When, as_json, file_name, for_moodle, marks_sheet, sheets
from server.marks.schemas import Book

CSV = "text/csv; charset=utf-8"


class Format(StrEnum):
    """What a gradebook may be taken away as."""

    json = "json"
    csv = "csv"
    xlsx = "xlsx"
    moodle = "moodle"

    @property
    def media_type(self) -> str:
        return {
            Format.json: "application/json",
            Format.xlsx: "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
        }.get(self, CSV)


@dataclass(frozen=True)
class Taken:
    name: str
    content: bytes
    media_type: str
    more: Mapping[str, str] = field(default_factory=dict)

    @property
    def headers(self) -> dict[str, str]:
        kept = {"Content-Disposition": f'attachment; filename="{self.name}"', "Cache-Control": "private, no-store"}
        return {**kept, **self.more}


def taken(book: Book, format: Format, identifier: Identifier, when: When) -> Taken:
    """`identifier` is for Moodle's file alone: `X-Balise-Left-Out` says how many students it is without."""
    kind = format.media_type
    if format is Format.xlsx:
        return Taken(file_name(book, "notes", "xlsx"), xlsx(sheets(book, when)), kind)
    if format is Format.csv:
        sheet = marks_sheet(book)
        return Taken(file_name(book, "notes", "csv"), b"".join(french_csv(sheet.header, sheet.rows)), kind)
    if format is Format.moodle:
        made = for_moodle(book, identifier)
        left_out = {"X-Balise-Left-Out": str(len(made.left_out))}
        return Taken(file_name(book, "moodle", "csv"), b"".join(made.pieces()), kind, left_out)
    content = json.dumps(as_json(book), default=_plain, ensure_ascii=False, indent=1)
    return Taken(file_name(book, "notes", "json"), content.encode(), kind)


def _plain(value: object) -> str:
    """Raises TypeError for what is neither a date nor a name."""
    if isinstance(value, datetime):
        return value.isoformat()
    if isinstance(value, UUID):
        return str(value)
    raise TypeError(value)
