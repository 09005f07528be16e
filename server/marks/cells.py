"""Tables as files that programs for tables open: text that no program takes for a formula, numbers as its readers write
them."""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from server.marks.means import format_number

Cell = str | float | None
FORMULA = re.compile(r"\s*[=+\-@\t\r＝＋－＠]|[\t\r\n]")
BOM = "\ufeff"
NAME_LENGTH = 60
WIDEST = 60


@dataclass(frozen=True)
class Sheet:
    """A table with its header. `frozen` columns stay in sight; None is an empty cell."""

    title: str
    header: tuple[str, ...]
    rows: Sequence[Sequence[Cell]]
    frozen: int = 0


def escape_formula(text: str) -> str:
    """Behind an apostrophe where a program would take it for a formula: the text stays to be read."""
    return f"'{text}" if FORMULA.match(text) else text


def french_csv(header: Sequence[Cell], rows: Iterable[Sequence[Cell]]) -> Iterator[bytes]:
    """For a French Excel: UTF-8 with its mark, « ; », decimal comma, CRLF, every cell quoted. In pieces."""
    yield (BOM + _line(header, ";", ",")).encode()
    for row in rows:
        yield _line(row, ";", ",").encode()


def plain_csv(header: Sequence[Cell], rows: Iterable[Sequence[Cell]]) -> Iterator[bytes]:
    """UTF-8 without a mark, commas, decimal point: for programs."""
    for row in (header, *rows):
        yield _line(row, ",", ".").encode()


def _line(row: Sequence[Cell], separator: str, sign: str) -> str:
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, quoting=csv.QUOTE_ALL, lineterminator="\r\n")
    writer.writerow([_text(cell, sign) for cell in row])
    return text.getvalue()


def _text(cell: Cell, sign: str) -> str:
    if cell is None:
        return ""
    return escape_formula(cell) if isinstance(cell, str) else format_number(cell, sign)


def xlsx(sheets: Iterable[Sheet]) -> bytes:
    """Numbers as numbers, text as text that is never a formula, the header and the names always in sight."""
    import xlsxwriter

    content = io.BytesIO()
    with xlsxwriter.Workbook(content, {"in_memory": True}) as book:
        styles = {
            "head": book.add_format({"bold": True, "text_wrap": True, "valign": "top", "bottom": 1}),
            "mark": book.add_format({"num_format": "0.##"}),
            "text": book.add_format({}),
            "kept": book.add_format({"quote_prefix": True}),
            "note": book.add_format({"text_wrap": True, "valign": "top"}),
        }
        for one in sheets:
            _write(book.add_worksheet(one.title), one, styles)
    return content.getvalue()


def _write(page, one: Sheet, styles) -> None:  # type: ignore[no-untyped-def]
    for column, title in enumerate(one.header):
        page.write_string(0, column, title, styles["head"])
    for line, row in enumerate(one.rows, 1):
        for column, cell in enumerate(row):
            if isinstance(cell, str):
                page.write_string(line, column, cell, styles["kept" if FORMULA.match(cell) else "text"])
            elif cell is not None:
                page.write_number(line, column, cell, styles["mark"])
    page.freeze_panes(1, one.frozen)
    for column, width in enumerate(_widths(one)):
        page.set_column(column, column, width)


def _widths(one: Sheet) -> list[int]:
    columns = zip(*(one.header, *one.rows), strict=True)
    return [min(WIDEST, max(8, *(len(cell) + 2 for cell in column if isinstance(cell, str)))) for column in columns]


def ascii_slug(text: str, otherwise: str) -> str:
    """A piece of a file's name that every system takes: « MPSI 2 » gives « mpsi-2 »."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode().lower()
    return "-".join(re.findall(r"[a-z0-9]+", plain))[:NAME_LENGTH].strip("-") or otherwise
