"""A program that converts the sheets of a spreadsheet on standard input to JSON lists of texts.

A few kilobytes may hold a sheet of a billion cells: the process has its own resource limits, and ends beyond them.
"""

from __future__ import annotations

import io
import json
import os
import re
import resource
import sys
import zipfile
from collections.abc import Iterator, Sequence
from typing import IO, Any
from xml.etree import ElementTree

MAX_LINES, MAX_COLUMNS = 2000, 50
MAX_TEXT = 1024 * 1024  # characters in all: a text stored once may stand in every cell
MAX_SHEETS = 5
FORMULA = "#FORMULE!"  # before the name of a cell whose formula has no value: a program wrote it, and no one opened it
MEMORY = 512 * 1024 * 1024  # of address space, the interpreter included
SECONDS = 5
NICE = 10  # pages go first


def limit_resources() -> None:
    os.nice(NICE)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def cell_text(cell: Any) -> str:
    """Return a cell as text; whole numbers without decimals, since spreadsheets store numeric identifiers as floats."""
    if isinstance(cell, float) and cell.is_integer() and abs(cell) < 2**53:
        return str(int(cell))
    return str(cell)


Sheet = list[list[str]]


def read_sheets(content: bytes) -> Iterator[Sheet]:
    """Yield the first sheets, with one line and one column beyond the bounds so that the caller can refuse them."""
    from python_calamine import CalamineWorkbook

    workbook = CalamineWorkbook.from_filelike(io.BytesIO(content))
    for index in range(min(len(workbook.sheet_names), MAX_SHEETS)):
        rows: Sequence[Sequence[Any]] = workbook.get_sheet_by_index(index).to_python(skip_empty_area=False)
        sheet = [[cell_text(cell) for cell in row[: MAX_COLUMNS + 1]] for row in rows[: MAX_LINES + 1]]
        for line, column in _find_formulas_without_values(content, index):
            if line < MAX_LINES and column < MAX_COLUMNS:
                _set_cell(sheet, line, column, f"{FORMULA}{cell_name(line, column)}")
        yield sheet


def _set_cell(sheet: Sheet, line: int, column: int, text: str) -> None:
    while len(sheet) <= line:
        sheet.append([])
    row = sheet[line]
    row += [""] * (column + 1 - len(row))
    row[column] = row[column] or text


def cell_name(line: int, column: int) -> str:
    """Return the name of a cell by its indices from 0, as B3; columns up to ZZ."""
    first, last = divmod(column, 26)
    return f"{chr(ord('A') + first - 1) if first else ''}{chr(ord('A') + last)}{line + 1}"


def _find_formulas_without_values(content: bytes, index: int) -> Iterator[tuple[int, int]]:
    """Yield line and column, from 0, of the formulas of a sheet whose value the file does not hold."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        if "content.xml" in archive.namelist():
            yield from _find_ods_formulas_without_values(archive.open("content.xml"), index)
            return
        path = _sheet_path_in_archive(archive, index)
        if path:
            yield from _find_xlsx_formulas_without_values(archive.open(path))


def _sheet_path_in_archive(archive: zipfile.ZipFile, index: int) -> str:
    """Return the part of an XLSX file that holds a sheet, or an empty text."""
    book = ElementTree.fromstring(archive.read("xl/workbook.xml"))
    sheets = [element for element in book.iter() if element.tag.endswith("}sheet")]
    wanted = next((value for name, value in sheets[index].attrib.items() if name.endswith("}id")), "")
    relations = ElementTree.fromstring(archive.read("xl/_rels/workbook.xml.rels"))
    target = next((each.get("Target", "") for each in relations if each.get("Id") == wanted), "")
    path = target.removeprefix("/") if target.startswith("/") else f"xl/{target}"
    return path if path in archive.namelist() else ""


def _find_xlsx_formulas_without_values(file: IO[bytes]) -> Iterator[tuple[int, int]]:
    for _, cell in ElementTree.iterparse(file):
        name = cell.tag.rpartition("}")[2]
        if name == "c":
            parts = {part.tag.rpartition("}")[2]: part.text for part in cell}
            found = re.fullmatch(r"([A-Z]{1,3})(\d{1,7})", cell.get("r", ""))
            if "f" in parts and not parts.get("v") and found:
                yield int(found[2]) - 1, _column_index(found[1])
        if name == "row":
            cell.clear()


def _column_index(letters: str) -> int:
    index = 0
    for letter in letters:
        index = 26 * index + ord(letter) - ord("A") + 1
    return index - 1


def _find_ods_formulas_without_values(file: IO[bytes], index: int) -> Iterator[tuple[int, int]]:
    sheet, line, column = -1, 0, 0
    for event, element in ElementTree.iterparse(file, ("start", "end")):
        name = element.tag.rpartition("}")[2]
        if event == "start":
            if name == "table":
                sheet, line = sheet + 1, 0
            elif name == "table-row":
                column = 0
        elif name in {"table-cell", "covered-table-cell"}:
            attributes = {key.rpartition("}")[2]: value for key, value in element.attrib.items()}
            has_value = any("".join(part.itertext()) for part in element) or "value" in attributes
            if sheet == index and "formula" in attributes and not has_value:
                yield line, column
            column += int(attributes.get("number-columns-repeated", 1))
        elif name == "table-row":
            line += int(next((v for k, v in element.attrib.items() if k.endswith("}number-rows-repeated")), 1))
            element.clear()


if __name__ == "__main__":
    limit_resources()
    sheets: list[Sheet] = []
    size = 0
    for sheet in read_sheets(sys.stdin.buffer.read()):
        size += sum(len(cell) for row in sheet for cell in row)
        if size > MAX_TEXT:
            break
        sheets.append(sheet)
    if not sheets:
        sys.exit("too much text")
    json.dump(sheets, sys.stdout)
