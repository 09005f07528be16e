"""Find the headers of a school's list among its first rows, and settle which columns count.

What is in doubt is asked, never guessed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from server.classes.headers import (
    FULL_NAMES,
    KNOWN_TO_STUDENTS,
    NAMES,
    PLURAL,
    ColumnReading,
    RosterField,
    recognise_header,
)
from server.classes.rows import SheetRow

HEADER_ROWS = 20


@dataclass(frozen=True)
class RosterHeader:
    """Where the headers stand: `rows` rows of the list end with them. `doubt` says why a person has to look."""

    columns: tuple[ColumnReading, ...]
    rows: int
    line: int
    doubt: str = ""

    def columns_of(self, field: RosterField) -> list[ColumnReading]:
        """Return the columns of a field, those that count first before the others."""
        return sorted((c for c in self.columns if c.field is field), key=lambda c: (-c.rank, c.index))

    @property
    def has_names(self) -> bool:
        return bool(self.fields & NAMES)

    @property
    def fields(self) -> frozenset[RosterField]:
        return frozenset(column.field for column in self.columns if column.field)


def find_header(rows: Sequence[SheetRow]) -> RosterHeader | None:
    """Return the headers among the first rows: the first row that names most columns, a name at least."""
    best: tuple[int, int] | None = None
    for place, row in enumerate(rows[:HEADER_ROWS]):
        fields = {reading.field for cell in row.cells if cell.strip() and (reading := recognise_header(cell)).field}
        is_header = fields & NAMES and not any("@" in cell for cell in row.cells)
        if is_header and (best is None or len(fields) > best[0]):
            best = len(fields), place
    return None if best is None else _read_header_at(rows, best[1])


def _read_header_at(rows: Sequence[SheetRow], place: int) -> RosterHeader:
    width = max(len(row.cells) for row in rows)
    cells = list(rows[place].cells) + [""] * (width - len(rows[place].cells))
    last = place
    above = _merged_cells_above(rows, place, width)
    below = _second_header_row(rows, place, cells)
    if below:
        last = place + 1
        cells = [
            _combine_header_rows(cell, sub, before)
            for cell, sub, before in zip(cells, below, _spread_merged_headers(cells), strict=True)
        ]
    columns = []
    for index, cell in enumerate(cells):
        header = cell if cell.strip() else above[index]
        columns.append(replace(recognise_header(header.strip()), index=index, header=header.strip()))
    while columns and not columns[-1].header:
        columns.pop()
    readings, doubt = _drop_redundant_columns(tuple(columns), rows[last + 1 :])
    return RosterHeader(readings, last + 1, rows[place].line, doubt)


def _merged_cells_above(rows: Sequence[SheetRow], place: int, width: int) -> list[str]:
    """Return the cells of the row above: headers that are merged over two rows stand there. A title stands alone."""
    cells = list(rows[place - 1].cells) if place else []
    is_title = sum(bool(cell.strip()) for cell in cells) < 2 or rows[place].line - rows[place - 1].line > 1
    cells = [] if is_title else cells
    return [*cells, *[""] * (width - len(cells))]


def _second_header_row(rows: Sequence[SheetRow], place: int, cells: Sequence[str]) -> list[str]:
    """Return a second row of headers, as under a cell merged over several columns, or an empty list."""
    if place + 1 >= len(rows):
        return []
    below = [*rows[place + 1].cells, *[""] * (len(cells) - len(rows[place + 1].cells))][: len(cells)]
    filled = [index for index, cell in enumerate(below) if cell.strip()]
    spread = _spread_merged_headers(cells)
    names_all = all(
        recognise_header(below[i]).field or recognise_header(f"{spread[i]} {below[i]}").field for i in filled
    )
    return below if filled and names_all else []


def _spread_merged_headers(cells: Sequence[str]) -> list[str]:
    """Repeat each header over the empty cells on its right, as a merged cell means."""
    spread, current = [], ""
    for cell in cells:
        current = cell if cell.strip() else current
        spread.append(current)
    return spread


def _combine_header_rows(cell: str, sub: str, merged: str) -> str:
    if not sub.strip():
        return cell
    alone = recognise_header(sub)
    both = f"{merged} {sub}"
    return sub if alone.field and not recognise_header(both).field else both if recognise_header(both).field else sub


TWO = "deux colonnes donnent « {field} » ({first} et {second})"


def _drop_redundant_columns(
    columns: tuple[ColumnReading, ...], rows: Sequence[SheetRow]
) -> tuple[tuple[ColumnReading, ...], str]:
    """Leave aside what the columns beside make needless; also return what only a person can decide."""
    fields = {column.field for column in columns}
    if {RosterField.family, RosterField.given} <= fields:
        columns = _reassign_fields(columns, FULL_NAMES, None)
    elif RosterField.given in fields:  # « Élève » beside « Prénom »: the name of the family
        columns = _reassign_fields(columns, FULL_NAMES, RosterField.family)
    elif fields & FULL_NAMES:
        columns = _reassign_fields(columns, {RosterField.family}, None)
    columns = tuple(replace(column, field=None) if _is_line_counter(column, rows) else column for column in columns)
    doubt = ""
    settled: list[ColumnReading] = []
    for column in columns:
        rival = _find_duplicate_column(column, settled)
        is_needless = rival and (
            column.field not in NAMES or _column_values(column, rows) == _column_values(rival, rows) != []
        )
        if rival and not is_needless and not doubt:
            doubt = TWO.format(field=column.field, first=f"« {rival.header} »", second=f"« {column.header} »")
        settled.append(replace(column, field=None) if is_needless else column)
    return tuple(settled), doubt


def _find_duplicate_column(column: ColumnReading, earlier: Sequence[ColumnReading]) -> ColumnReading | None:
    """Return an earlier column with the same meaning and rank; columns of groups are read together."""
    if column.field is None or column.field in PLURAL:
        return None
    return next((each for each in earlier if each.field is column.field and each.rank == column.rank), None)


def _reassign_fields(
    columns: Iterable[ColumnReading], fields: Collection[RosterField], new_field: RosterField | None
) -> tuple[ColumnReading, ...]:
    return tuple(replace(column, field=new_field) if column.field in fields else column for column in columns)


def _column_values(column: ColumnReading, rows: Sequence[SheetRow]) -> list[str]:
    return [row.cells[column.index].strip() if column.index < len(row.cells) else "" for row in rows]


def _is_line_counter(column: ColumnReading, rows: Sequence[SheetRow]) -> bool:
    """Whether a column of numbers counts the lines: small numbers that grow."""
    if column.field is not RosterField.number or column.rank == KNOWN_TO_STUDENTS:
        return False
    values = [value for value in _column_values(column, rows) if value]
    numbers = [int(value) for value in values if value.isascii() and value.isdigit() and len(value) < 5]
    return len(numbers) * 2 >= len(values) and all(a < b for a, b in pairwise(numbers))


def columns_chosen_by_user(fields: Sequence[str], known: Sequence[ColumnReading] = ()) -> tuple[ColumnReading, ...]:
    """Return the columns as somebody says, unknown words leave one aside; `known`: as their headers say."""
    names = {field.value: field for field in RosterField}
    columns = []
    for index, name in enumerate(fields):
        column = known[index] if index < len(known) else ColumnReading(index, "")
        wanted = names.get(name)
        if wanted is not column.field:
            column = replace(column, field=wanted, rank=2, qualifier="")
        columns.append(column)
    return tuple(columns)
