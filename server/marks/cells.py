"""Tables as CSV and XLSX files, in which no text is taken for a formula."""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from graders.typography import limit_marks
from server.marks.means import format_number

Cell = str | float | None
FORMULA = re.compile(r"\s*[=+\-@\t\r＝＋－＠]|[\t\r\n]")
BOM = "\ufeff"
MAX_SLUG_LENGTH = 60
MAX_WIDTH = 60


@dataclass(frozen=True)
class WorkbookSheet:
    """A table with its header. The first `frozen` columns stay visible; None is an empty cell."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]
    frozen: int = 0


def escape_formula(text: str) -> str:
    """Prefix with an apostrophe what a spreadsheet would take for a formula."""
    return f"'{text}" if FORMULA.match(text) else text


def write_french_csv(header: Sequence[Cell], rows: Iterable[Sequence[Cell]]) -> Iterator[bytes]:
    """Yield the lines of a CSV file for a French Excel: UTF-8 with BOM, « ; », decimal comma, CRLF, all quoted."""
    yield (BOM + _format_csv_line(header, ";", ",")).encode()
    for row in rows:
        yield _format_csv_line(row, ";", ",").encode()


def write_plain_csv(header: Sequence[Cell], rows: Iterable[Sequence[Cell]]) -> Iterator[bytes]:
    """Yield the lines of a CSV file for programs: UTF-8 without BOM, commas, decimal point."""
    for row in (header, *rows):
        yield _format_csv_line(row, ",", ".").encode()


def _format_csv_line(row: Sequence[Cell], separator: str, decimal_sign: str) -> str:
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, quoting=csv.QUOTE_ALL, lineterminator="\r\n")
    writer.writerow([_format_cell(cell, decimal_sign) for cell in row])
    return text.getvalue()


def _format_cell(cell: Cell, decimal_sign: str) -> str:
    if cell is None:
        return ""
    return escape_formula(cell) if isinstance(cell, str) else format_number(cell, decimal_sign)


def build_xlsx(sheets: Iterable[WorkbookSheet]) -> bytes:
    """Return a workbook: numbers as numbers, text never as formulas, header and names always visible."""
    import xlsxwriter

    content = io.BytesIO()
    with xlsxwriter.Workbook(content, {"in_memory": True}) as book:
        styles = {
            "head": book.add_format({"bold": True, "text_wrap": True, "valign": "top", "bottom": 1}),
            "mark": book.add_format({"num_format": "0.##"}),
            "text": book.add_format({}),
            "quoted": book.add_format({"quote_prefix": True}),
            "note": book.add_format({"text_wrap": True, "valign": "top"}),
        }
        for sheet in sheets:
            _write_worksheet(book.add_worksheet(sheet.title), sheet, styles)
    return content.getvalue()


def _write_worksheet(page, sheet: WorkbookSheet, styles) -> None:  # type: ignore[no-untyped-def]
    for column, title in enumerate(sheet.header):
        page.write_string(0, column, title, styles["head"])
    for line, row in enumerate(sheet.rows, 1):
        for column, cell in enumerate(row):
            if isinstance(cell, str):
                page.write_string(line, column, cell, styles["quoted" if FORMULA.match(cell) else "text"])
            elif cell is not None:
                page.write_number(line, column, cell, styles["mark"])
    page.freeze_panes(1, sheet.frozen)
    for column, width in enumerate(_column_widths(sheet)):
        page.set_column(column, column, width)


def _column_widths(sheet: WorkbookSheet) -> list[int]:
    columns = zip(*(sheet.header, *sheet.rows), strict=True)
    return [min(MAX_WIDTH, max(8, *(len(cell) + 2 for cell in column if isinstance(cell, str)))) for column in columns]


def ascii_slug(text: str, default: str) -> str:
    """Return a part of a file name that every system accepts: « MPSI 2 » gives « mpsi-2 »."""
    plain = unicodedata.normalize("NFKD", limit_marks(text)).encode("ascii", "ignore").decode().lower()
    return "-".join(re.findall(r"[a-z0-9]+", plain))[:MAX_SLUG_LENGTH].strip("-") or default
