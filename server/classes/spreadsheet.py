"""A program that converts the first sheet of a spreadsheet on standard input to JSON lists of texts.

A few kilobytes may hold a sheet of a billion cells: the process has its own resource limits, and ends beyond them.
"""

from __future__ import annotations

import io
import json
import resource
import sys
from collections.abc import Sequence
from typing import Any

MAX_LINES, MAX_COLUMNS = 2000, 50
MAX_TEXT = 1024 * 1024  # characters in all: a text stored once may stand in every cell
MEMORY = 512 * 1024 * 1024  # of address space, the interpreter included
SECONDS = 5


def limit_resources() -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def cell_text(cell: Any) -> str:
    """Return a cell as text; whole numbers without decimals, since spreadsheets store numeric identifiers as floats."""
    if isinstance(cell, float) and cell.is_integer() and abs(cell) < 2**53:
        return str(int(cell))
    return str(cell)


def read_first_sheet(content: bytes) -> list[list[str]]:
    """Return the first sheet, with one line and one column beyond the bounds so that the caller can refuse them."""
    from python_calamine import CalamineWorkbook

    workbook = CalamineWorkbook.from_filelike(io.BytesIO(content))
    rows: Sequence[Sequence[Any]] = workbook.get_sheet_by_index(0).to_python(skip_empty_area=False)
    return [[cell_text(cell) for cell in row[: MAX_COLUMNS + 1]] for row in rows[: MAX_LINES + 1]]


if __name__ == "__main__":
    limit_resources()
    sheet = read_first_sheet(sys.stdin.buffer.read())
    if sum(len(cell) for row in sheet for cell in row) > MAX_TEXT:
        sys.exit("too much text")
    json.dump(sheet, sys.stdout)
