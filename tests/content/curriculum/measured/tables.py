"""The tables of the texts, and what a script says they must hold."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import server

FOLDER = Path(server.__file__).parents[1] / "curriculum" / "l20"
NUMBER = r"−?-?\d+(?: \d{3})*(?:,\d+)?"
UNITS = {"ms": 1e-3, "s": 1.0}
#: How far the growth of a measured time may be from that of the text: machines differ.
PACE = 10.0

Cell = float | tuple[float, float] | None  # a number, two that bound a column's values, or words that nothing checks
Rows = Callable[[], Iterable[Sequence[Cell]]]


@dataclass(frozen=True)
class Table:
    """A table of a lesson: `page` without its suffix, the cells of its head and those of its rows."""

    page: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def name(self) -> str:
        return f"{self.page} | {' | '.join(self.head)}"

    @property
    def tells_decimals(self) -> bool:
        return any(re.search(r"\d,\d|\d %|\d / \d", plain(cell)) for row in self.rows for cell in row)


@dataclass(frozen=True)
class Measure:
    """A script's claim to a table: `rows()` gives what stands right of the first `labels` columns.

    A number agrees when it differs by no more than half a unit of the last digit that is written, plus `within` (one
    number a column, or one for all), plus `share` of itself. `times` are columns of durations: there, only the growth
    from the first row is compared, to within its order of magnitude.
    """

    page: str
    head: str
    rows: Rows
    within: float | tuple[float, ...] = 0.0
    share: float = 0.0
    labels: int = 1
    times: frozenset[int] = field(default_factory=frozenset)

    def faults(self, table: Table) -> list[str]:
        """The cells that do not agree, said with what was measured."""
        measured = [tuple(row) for row in self.rows()]
        if len(measured) != len(table.rows):
            return [f"{len(table.rows)} rows, {len(measured)} measured"]
        found = []
        for column in range(len(measured[0])):
            cells = [row[self.labels + column] for row in table.rows]
            values = [row[column] for row in measured]
            judged = _growth(cells, values) if column in self.times else zip(cells, values, strict=True)
            found += [f"{cell!r}: {value}" for cell, value in judged if not self._agrees(cell, value, column)]
        return found

    def _agrees(self, cell: str, value: Cell, column: int) -> bool:
        if column in self.times:
            return isinstance(value, float) and 1.0 / PACE < value < PACE
        more = self.within if isinstance(self.within, float) else self.within[column]
        return agrees(cell, value, more, self.share)


def _growth(cells: list[str], values: list[Cell]) -> Iterator[tuple[str, Cell]]:
    """For each duration, how many times faster it grew than the text says; words are left out."""
    told = [(cell, seconds(cell), value) for cell, value in zip(cells, values, strict=True) if isinstance(value, float)]
    _, first_told, first = told[0]
    for cell, text, value in told[1:]:
        yield cell, (value / first) / (text / first_told)


def tables(folder: Path = FOLDER) -> list[Table]:
    """All tables of the lessons, statements and hints of a module."""
    return [table for path in sorted(folder.glob("**/*.md")) for table in _tables_of(path, folder)]


def _tables_of(path: Path, folder: Path) -> Iterator[Table]:
    page = path.relative_to(folder).with_suffix("").as_posix()
    block: list[tuple[str, ...]] = []
    for line in [*path.read_text(encoding="utf-8").splitlines(), ""]:
        if line.startswith("|"):
            block.append(tuple(cell.strip() for cell in line.strip().strip("|").split("|")))
        elif block:
            yield Table(page, block[0], tuple(block[2:]))
            block = []


def plain(cell: str) -> str:
    """A cell without bold, TeX and spaces that do not break."""
    text = re.sub(r"\\[,;]", " ", cell.replace("{,}", ","))
    return re.sub(r"[*$]", "", text).replace("\u202f", " ").replace("\xa0", " ").strip()


def number(text: str) -> float:
    return float(text.replace(" ", "").replace("−", "-").replace(",", "."))


def seconds(cell: str) -> float:
    """A duration that a cell tells in s or ms."""
    match = re.fullmatch(rf"({NUMBER}) (ms|s)", plain(cell))
    if match is None:
        raise ValueError(f"« {cell} » is no duration")
    return number(match[1]) * UNITS[match[2]]


def agrees(cell: str, value: Cell, within: float = 0.0, share: float = 0.0) -> bool:
    """Does a cell tell this value? « plus de », « moins de » and « entre … et … » are bounds; « a / b » is a share."""
    text = plain(cell)
    if value is None:
        return True
    if power := re.search(r"10\^\{?-(\d+)\}?", text):
        return isinstance(value, float) and value < 10.0 ** -int(power[1])
    if fraction := re.search(r"(\d+) / (\d+)", text):
        return isinstance(value, float) and abs(int(fraction[1]) / int(fraction[2]) - value) <= within + 1e-9
    numbers = re.findall(NUMBER, text)
    return bool(numbers) and _holds(text, numbers, value, within, share)


def _holds(text: str, numbers: list[str], value: float | tuple[float, float], within: float, share: float) -> bool:
    if isinstance(value, tuple):
        ends = (numbers[0], numbers[-1])
        return all(_near(end, one, within, share) for end, one in zip(ends, value, strict=True))
    if text.startswith("plus de"):
        return value >= number(numbers[0])
    if text.startswith("entre"):
        return number(numbers[0]) - within <= value <= number(numbers[1]) + within
    return _near(numbers[0], value, within, share)


def _near(told: str, value: float, within: float, share: float) -> bool:
    digits = len(told.partition(",")[2])
    return abs(number(told) - value) <= 0.501 * 10.0**-digits + within + share * abs(value)
