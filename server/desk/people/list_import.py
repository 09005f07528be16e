"""The form of a list: what was typed or uploaded, and how a person says that it is read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from starlette.datastructures import FormData, UploadFile

from server.base.errors import Invalid
from server.classes.encodings import AS_IS, ENCODINGS, redecode
from server.classes.headers import FIELD_WORDS, ColumnReading
from server.classes.roster import ReadingChoice
from server.classes.sheets import SheetReading
from server.classes.spreadsheet import MAX_COLUMNS, MAX_LINES

NO_LIST = "Collez une liste, ou choisissez un fichier."
REPLACE = "remplacer"
MAX_FIELD = 200
SAMPLES, SAMPLE_LENGTH, FIRST = 3, 80, 25


@dataclass(frozen=True)
class ListForm:
    """A form of the list's page. `read_as`: the encoding in which the list was read before; `expected`: the digest of
    the changes that were shown, to write them."""

    content: bytes
    text: str
    choice: ReadingChoice
    replace: bool
    read_as: str
    expected: str

    @property
    def is_first(self) -> bool:
        """Whether nobody has seen yet how the list is read."""
        return not self.read_as

    def require_content(self) -> None:
        """Raise Invalid where there is no list."""
        if not self.content.strip():
            raise Invalid(NO_LIST)


def read_list_form(fields: FormData) -> ListForm:
    """Read the form. Raises Invalid."""
    upload, text = fields.get("fichier"), _form_text(fields, "texte", longest=None)
    is_uploaded = isinstance(upload, UploadFile) and bool(upload.filename)
    content = upload.file.read() if is_uploaded and isinstance(upload, UploadFile) else b""
    read_as, wanted = _form_text(fields, "lu"), _form_text(fields, "accents")
    if not is_uploaded and read_as in ENCODINGS and wanted in ENCODINGS and wanted != read_as:
        text, read_as = redecode(text, read_as, wanted), wanted
    columns = tuple(str(name)[:MAX_FIELD] for name in fields.getlist("colonne"))[:MAX_COLUMNS]
    first_line = _form_text(fields, "premiere")
    choice = ReadingChoice(
        columns=() if is_uploaded else columns,
        first_line=int(first_line) if first_line.isdecimal() and int(first_line) <= MAX_LINES else 0,
        encoding="" if is_uploaded or not read_as else AS_IS,
        class_value=_form_text(fields, "valeur"),
        only_here=bool(_form_text(fields, "ici")),
    )
    return ListForm(
        content=content or text.encode(errors="replace"),
        text=text,
        choice=choice,
        replace=_form_text(fields, "mode") == REPLACE,
        read_as="" if is_uploaded else read_as,
        expected=_form_text(fields, "attendu"),
    )


def _form_text(fields: FormData, name: str, longest: int | None = MAX_FIELD) -> str:
    value = fields.get(name, "")
    return value[:longest] if isinstance(value, str) else ""


def build_columns(source: SheetReading, columns: Sequence[ColumnReading], read_as: str, rows: int) -> dict[str, Any]:
    """Build the question which column is which: the columns with their first cells. `rows`: of headers; `read_as`: the
    encoding of the text."""
    people = source.rows[rows : rows + SAMPLES] or source.rows[:SAMPLES]
    return {
        "columns": [
            (column, [row.cells[column.index] if column.index < len(row.cells) else "" for row in people])
            for column in columns
        ],
        "fields": FIELD_WORDS.items(),
        "first_lines": [(row.line, " · ".join(filter(None, row.cells))[:SAMPLE_LENGTH]) for row in source.rows[:FIRST]],
        "first_line": source.rows[rows].line if rows < len(source.rows) else source.rows[0].line,
        "read_as": read_as or source.encoding or "xlsx",
        "encodings": ENCODINGS.items() if (read_as or source.encoding) in ENCODINGS else (),
    }
