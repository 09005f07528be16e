"""Parse the rows of a school's list of students, with the line number and the problem of each rejected row."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from server.base.errors import Invalid
from server.classes.columns import HEADER_ROWS, RosterHeader, columns_chosen_by_user, find_header
from server.classes.folding import normalise_name
from server.classes.headers import ColumnReading, RosterField
from server.classes.line_reader import LineReader
from server.classes.roster_line import RejectedLine, RosterLine
from server.classes.rows import SheetRow
from server.classes.sheets import SheetReading, read_rows

#: The columns of the contract.
COLUMNS = ("nom", "prenom", "email", "identifiant", "groupe")
EVERY_CLASS = "*"

NO_NAME = "Dites quelle colonne donne le nom, ou le prénom."
EMPTY = "Cette liste est vide."
NO_HEADER = (
    "Aucune des vingt premières lignes ne paraît nommer les colonnes : nom, prénom, email, identifiant, groupe "
    "(« nom » suffit ; leur ordre est libre). Dites laquelle est laquelle, ou ajoutez cette ligne."
)


@dataclass(frozen=True)
class ReadingChoice:
    """How a person says that a list is read. `columns`: a field for each column, empty to leave it aside; `first_line`:
    the line of the first person, 0 for the one after the headers; `encoding`: empty for the likeliest. `class_value`:
    the value of the column of classes that is this class, `EVERY_CLASS` for any, empty for the one of its name;
    `only_here`: the other classes that it names stay as they are."""

    columns: tuple[str, ...] = ()
    first_line: int = 0
    encoding: str = ""
    class_value: str = ""
    only_here: bool = False


AS_WRITTEN = ReadingChoice()


class UndecidedColumns(Invalid):
    """The list's columns are in doubt: a person says which is which. It holds the list, as far as it is read."""

    def __init__(self, detail: str, source: SheetReading, columns: Sequence[ColumnReading]) -> None:
        super().__init__(detail)
        self.source = source
        self.columns = tuple(columns)


@dataclass(frozen=True)
class Roster:
    """A parsed list. `has_groups`: it has a column for groups, so that an empty cell means none."""

    source: SheetReading
    header: RosterHeader
    lines: tuple[RosterLine, ...]
    rejected: tuple[RejectedLine, ...]
    warnings: tuple[str, ...] = ()
    class_values: Mapping[str, int] = field(default_factory=dict)

    @property
    def rows(self) -> tuple[SheetRow, ...]:
        return self.source.rows

    @property
    def has_groups(self) -> bool:
        return RosterField.group in self.header.fields

    @property
    def ignored_headers(self) -> tuple[str, ...]:
        """The headers of the columns of which nothing is kept: a number or a birth date only tells namesakes apart."""
        unkept = {None, RosterField.birth}
        if not any(line.login and line.key.startswith(line.login) for line in self.lines):
            unkept.add(RosterField.number)
        if len(self.class_values) < 2:
            unkept.add(RosterField.school_class)
        return tuple(column.header for column in self.header.columns if column.field in unkept and column.header)


def read_roster(content: bytes, choice: ReadingChoice = AS_WRITTEN) -> Roster:
    """Parse a file. Raises Invalid where it is no list at all, UndecidedColumns where its columns are in doubt, or
    Overloaded; bad lines are rejected one by one."""
    return parse_roster(read_rows(content, choice.encoding or None), choice)


def parse_roster(source: SheetReading, choice: ReadingChoice = AS_WRITTEN) -> Roster:
    """Parse the rows of a file. Raises as `read_roster`."""
    if not source.rows:
        raise Invalid(EMPTY)
    header = _read_header(source, choice)
    reader = LineReader(header)
    lines: list[RosterLine] = []
    rejected: list[RejectedLine] = []
    titles = {_fold_row_text(row) for row in source.rows[: header.rows]}
    people = [
        row for row in source.rows[header.rows :] if _fold_row_text(row) not in titles
    ]  # headers come back on each page
    for row in people:
        line = reader.read_line(row)
        try:
            reader.require_well_formed(line, row)
            reader.require_unique(line)
        except Invalid as problem:
            rejected.append(RejectedLine(row.line, problem.detail, line.name, line.login))
        else:
            lines.append(line)
    classes = Counter(line.school_class for line in lines if line.school_class)
    return Roster(source, header, tuple(lines), tuple(rejected), reader.warnings(source), classes)


def _fold_row_text(row: SheetRow) -> str:
    return " | ".join(map(normalise_name, row.cells))


def _read_header(source: SheetReading, choice: ReadingChoice) -> RosterHeader:
    header = find_header(source.rows)
    if choice.columns:
        return _header_chosen_by_user(source, choice, header)
    if header is None:
        width = max(len(row.cells) for row in source.rows)
        raise UndecidedColumns(NO_HEADER, source, columns_chosen_by_user([""] * width))
    if header.doubt:
        raise UndecidedColumns(
            f"Ligne {header.line} : {header.doubt}. Dites laquelle est la bonne.", source, header.columns
        )
    return header


def _header_chosen_by_user(source: SheetReading, choice: ReadingChoice, header: RosterHeader | None) -> RosterHeader:
    """Return the columns as a person says; those that say the same as the headers are read as these say."""
    rows = header.rows if header else 0
    if choice.first_line:
        rows = sum(row.line < choice.first_line for row in source.rows)
    known = header.columns if header else ()
    columns = columns_chosen_by_user(choice.columns, known)
    chosen = RosterHeader(columns, rows, header.line if header else 0)
    if not chosen.has_names:
        raise UndecidedColumns(NO_NAME, source, columns)
    return chosen


def header_signatures(rows: Sequence[SheetRow]) -> dict[str, int]:
    """Return the signatures of the first rows, with the line of the row after each: equal headers have equal ones."""
    first = rows[: HEADER_ROWS + 1]
    return {
        hashlib.sha256(_fold_row_text(row).encode()).hexdigest(): after.line
        for row, after in pairwise(first)
        if len(row.cells)
    }
