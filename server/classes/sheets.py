"""Read rows from a file: CSV or pasted text of any encoding and separator, XLSX, ODS. Rows keep their line numbers.

Everything is bounded: the service bounds the request, this module the rows; a spreadsheet is opened in a process of its
own (`spreadsheet.py`), since a small file may expand to any memory.
"""

from __future__ import annotations

import csv
import io
import json
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from threading import BoundedSemaphore

from server.base.errors import Invalid, Overloaded
from server.base.processes import bare_environment
from server.classes.spreadsheet import MAX_COLUMNS, MAX_LINES

SEPARATORS = (";", ",", "\t")
LINE_END = re.compile(r"\r\n|\r|\n")
ZIP, OLD_EXCEL = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
OPENING_SECONDS = 20.0  # wall time; the process bounds its own processor time
MAX_CONCURRENT = 2

OLD = "Ce fichier est d’un ancien format (.xls) : enregistrez-le en .xlsx, en .ods ou en CSV."
UNREADABLE = "Ce fichier ne se lit pas comme un classeur XLSX ou ODS ; enregistrez-le en CSV, ou collez la liste."
NOT_TEXT = "Ce fichier n’est pas un texte : ni UTF-8, ni Windows-1252. Enregistrez-le en CSV, en XLSX ou en ODS."
TOO_LONG = f"Une liste a {MAX_LINES} lignes et {MAX_COLUMNS} colonnes au plus."
BUSY = "D’autres listes sont en cours de lecture. Réessayez dans quelques secondes."

_opening = BoundedSemaphore(MAX_CONCURRENT)


@dataclass(frozen=True)
class SheetRow:
    """A row of cells; `line` is where it begins in the file, from 1."""

    line: int
    cells: tuple[str, ...]

    @property
    def is_blank(self) -> bool:
        return not any(cell.strip() for cell in self.cells)


def read_rows(content: bytes) -> list[SheetRow]:
    """Return the rows that are not blank. Raises Invalid, naming the line where there is one, or Overloaded."""
    if content.startswith(OLD_EXCEL):
        raise Invalid(OLD)
    rows = _spreadsheet_rows(content) if content.startswith(ZIP) else _text_rows(decode_text(content))
    filled = []
    for row in rows:
        if row.line > MAX_LINES or len(row.cells) > MAX_COLUMNS:
            raise Invalid(TOO_LONG)
        if not row.is_blank:
            filled.append(row)
    return filled


def to_csv(rows: Iterable[SheetRow]) -> str:
    """Return CSV text that `read_rows` reads back as these rows, on the same lines."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, delimiter=SEPARATORS[0], quoting=csv.QUOTE_ALL, lineterminator="\n")
    next_line = 1
    for row in rows:
        out.write("\n" * (row.line - next_line))
        writer.writerow(row.cells)
        next_line = row.line + 1 + sum(len(LINE_END.findall(cell)) for cell in row.cells)
    return out.getvalue()


def decode_text(content: bytes) -> str:
    """Decode UTF-8, with or without a BOM, UTF-16 with a BOM (Excel's « texte Unicode »), or else Windows-1252."""
    encodings = ["utf-16"] if content.startswith((b"\xff\xfe", b"\xfe\xff")) else ["utf-8-sig", "cp1252"]
    for encoding in encodings:
        try:
            text = content.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\x00" not in text:
            return text
    raise Invalid(NOT_TEXT)


def guess_separator(text: str) -> str:
    """Return the separator that splits the first line into most cells; among equals French Excel's comes first."""
    return max(SEPARATORS, key=lambda separator: _count_first_cells(text, separator))


def _count_first_cells(text: str, separator: str) -> int:
    """Count the cells of the first row; 0 where its quotes do not match with this separator."""
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    try:
        return next((len(row) for row in rows if row), 0)
    except csv.Error:
        return 0


def _text_rows(text: str) -> Iterator[SheetRow]:
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=guess_separator(text), strict=True)
    line = 1
    try:
        for cells in reader:
            yield SheetRow(line, tuple(cells))
            line = reader.line_num + 1
    except csv.Error as error:
        raise Invalid(f"Ligne {line} : les guillemets ne vont pas ensemble, ou une case est trop longue.") from error


def _spreadsheet_rows(content: bytes) -> Iterator[SheetRow]:
    if not _opening.acquire(timeout=OPENING_SECONDS):
        raise Overloaded(BUSY, retry_after=5)
    try:
        process = subprocess.run(
            [sys.executable, "-m", "server.classes.spreadsheet"],
            input=content,
            capture_output=True,
            timeout=OPENING_SECONDS,
            env=bare_environment(),
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise Invalid(UNREADABLE) from error
    finally:
        _opening.release()
    if process.returncode != 0:
        raise Invalid(UNREADABLE)
    for line, cells in enumerate(json.loads(process.stdout), 1):
        yield SheetRow(line, tuple(cells))
