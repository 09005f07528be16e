"""A file of rows, as it comes: CSV or pasted text of whatever encoding and separator, XLSX, ODS. Rows keep their lines.

Everything is bounded: the service bounds the request, this file the rows; a spreadsheet is opened in a process of its
own (`spreadsheet.py`), for a small one may ask for any memory.
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
OPENING_SECONDS = 20.0  # of waiting: the process has its own bound on what it computes
AT_ONCE = 2

OLD = "Ce fichier est d’un ancien format (.xls) : enregistrez-le en .xlsx, en .ods ou en CSV."
UNREADABLE = "Ce fichier ne se lit pas comme un classeur XLSX ou ODS ; enregistrez-le en CSV, ou collez la liste."
NOT_TEXT = "Ce fichier n’est pas un texte : ni UTF-8, ni Windows-1252. Enregistrez-le en CSV, en XLSX ou en ODS."
TOO_LONG = f"Une liste a {MAX_LINES} lignes et {MAX_COLUMNS} colonnes au plus."
BUSY = "D’autres listes sont en cours de lecture. Réessayez dans quelques secondes."

_opening = BoundedSemaphore(AT_ONCE)


@dataclass(frozen=True)
class SheetRow:
    """`line` is where it begins in the file, from 1."""

    line: int
    cells: tuple[str, ...]

    @property
    def is_blank(self) -> bool:
        return not any(cell.strip() for cell in self.cells)


def read_rows(content: bytes) -> list[SheetRow]:
    """The rows that are not blank. Raises Invalid, with the line where there is one, or Crowded."""
    if content.startswith(OLD_EXCEL):
        raise Invalid(OLD)
    rows = _spreadsheet(content) if content.startswith(ZIP) else _text(decode_text(content))
    found = []
    for row in rows:
        if row.line > MAX_LINES or len(row.cells) > MAX_COLUMNS:
            raise Invalid(TOO_LONG)
        if not row.is_blank:
            found.append(row)
    return found


def to_csv(rows: Iterable[SheetRow]) -> str:
    """A text that `read_rows` reads back as these rows, at the same lines."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, delimiter=SEPARATORS[0], quoting=csv.QUOTE_ALL, lineterminator="\n")
    at = 1
    for row in rows:
        out.write("\n" * (row.line - at))
        writer.writerow(row.cells)
        at = row.line + 1 + sum(len(LINE_END.findall(cell)) for cell in row.cells)
    return out.getvalue()


def decode_text(content: bytes) -> str:
    """UTF-8, with or without its mark; UTF-16 with its mark (Excel's « texte Unicode »); else Windows-1252."""
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
    """The one that cuts the first line in most pieces; of equals, the first of French Excel's, then of everybody's."""
    return max(SEPARATORS, key=lambda one: _pieces_of_first(text, one))


def _pieces_of_first(text: str, separator: str) -> int:
    """0 where its quotes do not go together, cut like this."""
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    try:
        return next((len(row) for row in rows if row), 0)
    except csv.Error:
        return 0


def _text(text: str) -> Iterator[SheetRow]:
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=guess_separator(text), strict=True)
    line = 1
    try:
        for cells in reader:
            yield SheetRow(line, tuple(cells))
            line = reader.line_num + 1
    except csv.Error as error:
        raise Invalid(f"Ligne {line} : les guillemets ne vont pas ensemble, ou une case est trop longue.") from error


def _spreadsheet(content: bytes) -> Iterator[SheetRow]:
    if not _opening.acquire(timeout=OPENING_SECONDS):
        raise Overloaded(BUSY, retry_after=5)
    try:
        done = subprocess.run(
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
    if done.returncode != 0:
        raise Invalid(UNREADABLE)
    for line, cells in enumerate(json.loads(done.stdout), 1):
        yield SheetRow(line, tuple(cells))
