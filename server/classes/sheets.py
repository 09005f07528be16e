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
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice
from threading import BoundedSemaphore

from server.base.errors import Invalid, Overloaded
from server.base.processes import bare_environment
from server.classes.columns import find_header
from server.classes.encodings import decode_text
from server.classes.rows import SheetRow
from server.classes.spreadsheet import MAX_COLUMNS, MAX_LINES

SEPARATORS = (";", ",", "\t", "|")
JUDGED_ROWS = 40  # of a text, to find its separator
DECLARED = re.compile(r"sep=(.)\r?\n", re.IGNORECASE)  # as Excel writes it
LINE_END = re.compile(r"\r\n|\r|\n")
ZIP, OLD_EXCEL, PDF = b"PK\x03\x04", b"\xd0\xcf\x11\xe0", b"%PDF-"
OPENING_SECONDS = 20.0  # wall time; the process bounds its own processor time
MAX_CONCURRENT = 4

OLD = "Ce fichier est d’un ancien format (.xls) : enregistrez-le en .xlsx, en .ods ou en CSV."
UNREADABLE = "Ce fichier ne se lit pas comme un classeur XLSX ou ODS ; enregistrez-le en CSV, ou collez la liste."
WEB_PAGE = (
    "Ce fichier est une page web, même s’il s’appelle .xls : ouvrez-le dans votre tableur et enregistrez-le en .xlsx, "
    "en .ods ou en CSV."
)
PRINTED = (
    "Ce fichier est un PDF, dont les colonnes ne se lisent pas : exportez la liste en .xlsx, en .ods ou en CSV, ou "
    "collez-la."
)
TOO_LONG = f"Une liste a {MAX_LINES} lignes et {MAX_COLUMNS} colonnes au plus."
BUSY = "D’autres listes sont en cours de lecture. Réessayez dans quelques secondes."

_opening = BoundedSemaphore(MAX_CONCURRENT)


@dataclass(frozen=True)
class SheetReading:
    """The rows of a file that are not blank, with how its text was decoded (`encodings.DecodedText`)."""

    rows: tuple[SheetRow, ...]
    encoding: str = ""
    other_encodings: tuple[str, ...] = ()
    repaired: tuple[tuple[str, str], ...] = ()


def read_rows(content: bytes, encoding: str | None = None) -> SheetReading:
    """Return the rows that are not blank, of the first sheet that names columns. Raises Invalid, naming the line where
    there is one, or Overloaded."""
    if content.startswith(OLD_EXCEL):
        raise Invalid(OLD)
    if content.startswith(PDF):
        raise Invalid(PRINTED)
    if content.startswith(ZIP):
        sheets = [_drop_blank_rows(sheet) for sheet in _read_spreadsheet_rows(content)]
        return SheetReading(next((rows for rows in sheets if find_header(rows)), sheets[0] if sheets else ()))
    if re.match(rb"(?:\xef\xbb\xbf)?\s*<(?:!doctype|html|table|\?xml|head|meta)\b", content[:200], re.IGNORECASE):
        raise Invalid(WEB_PAGE)
    decoded = decode_text(content, encoding)
    rows = _drop_blank_rows(_parse_text_rows(decoded.text))
    return SheetReading(rows, decoded.encoding, decoded.others, decoded.repaired)


def _drop_blank_rows(rows: Iterable[SheetRow]) -> tuple[SheetRow, ...]:
    filled = []
    for row in rows:
        if row.line > MAX_LINES or len(row.cells) > MAX_COLUMNS:
            raise Invalid(TOO_LONG)
        if not row.is_blank:
            filled.append(row)
    return tuple(filled)


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


def guess_separator(text: str) -> str:
    """Return the separator that cuts most rows into one number of cells; among equals French Excel's comes first."""
    return max(SEPARATORS, key=lambda separator: _column_count_regularity(text, separator))


def _column_count_regularity(text: str, separator: str) -> tuple[float, int]:
    """Return how many of the first rows have the commonest number of cells, of two at least, and this number; half as
    many where quotes do not match with this separator."""
    rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    widths: Counter[int] = Counter()
    fairness = 1.0
    try:
        widths.update(len(row) for row in islice(rows, JUDGED_ROWS))
    except csv.Error:
        fairness = 0.5
    width, count = max(
        ((width, count) for width, count in widths.items() if width > 1), key=lambda pair: pair[::-1], default=(0, 0)
    )
    return count * fairness, width


def _parse_text_rows(text: str) -> Iterator[SheetRow]:
    declared = DECLARED.match(text)
    separator = declared[1] if declared else guess_separator(text)
    reader = csv.reader(
        io.StringIO(text[declared.end() if declared else 0 :], newline=""), delimiter=separator, strict=True
    )
    skipped = 1 if declared else 0
    line = 1 + skipped
    try:
        for cells in reader:
            yield SheetRow(line, tuple(cells))
            line = reader.line_num + 1 + skipped
    except csv.Error as error:
        raise Invalid(f"Ligne {line} : les guillemets ne vont pas ensemble, ou une case est trop longue.") from error


def _read_spreadsheet_rows(content: bytes) -> list[list[SheetRow]]:
    """Return the rows of each sheet."""
    if not _opening.acquire(blocking=False):  # a wait here would take a thread from every page
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
    return [
        [SheetRow(line, tuple(cells)) for line, cells in enumerate(sheet, 1)] for sheet in json.loads(process.stdout)
    ]
