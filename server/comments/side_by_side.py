"""Two texts side by side: rows to show, the long runs that did not change folded, within bounds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, zip_longest
from typing import Literal

from server.comments.difference import DiffRun, diff_lines, split_lines

CONTEXT = 3
MAX_ROWS = 600
MAX_LINE_LENGTH = 300
CUT = " …"

Kind = Literal["same", "changed", "removed", "added", "folded"]


@dataclass(frozen=True)
class NumberedLine:
    """A line, with its number from 1; cut where it is very long."""

    number: int
    text: str


@dataclass(frozen=True)
class DiffRow:
    """A line before and after; None where there is none. `folded` rows stand for `hidden` lines of both."""

    kind: Kind
    before: NumberedLine | None = None
    after: NumberedLine | None = None
    hidden: int = 0


@dataclass(frozen=True)
class SideBySide:
    """`added` and `removed` count lines. `exact` as in `Difference`; `whole`: no row was left out at the end."""

    rows: tuple[DiffRow, ...]
    added: int
    removed: int
    is_exact: bool
    is_complete: bool


def compare_side_by_side(before: str, after: str) -> SideBySide:
    left, right = split_lines(before), split_lines(after)
    difference = diff_lines(left, right)
    rows = tuple(islice(_rows(difference.runs, left, right), MAX_ROWS + 1))
    changed = [run for run in difference.runs if not run.is_equal]
    return SideBySide(
        rows=rows[:MAX_ROWS],
        added=sum(len(run.after) for run in changed),
        removed=sum(len(run.before) for run in changed),
        is_exact=difference.is_exact,
        is_complete=len(rows) <= MAX_ROWS,
    )


def _rows(runs: Sequence[DiffRun], left: Sequence[str], right: Sequence[str]) -> Iterator[DiffRow]:
    for place, run in enumerate(runs):
        if run.is_equal:
            yield from _kept(run, left, right, is_first=place == 0, is_last=place == len(runs) - 1)
        else:
            for i, j in zip_longest(run.before, run.after):
                kind: Kind = "added" if i is None else "removed" if j is None else "changed"
                yield DiffRow(kind, _side(left, i), _side(right, j))


def _kept(
    run: DiffRun, left: Sequence[str], right: Sequence[str], *, is_first: bool, is_last: bool
) -> Iterator[DiffRow]:
    above, below = 0 if is_first else CONTEXT, 0 if is_last else CONTEXT
    pairs = list(zip(run.before, run.after, strict=True))
    hidden = len(pairs) - above - below
    if hidden <= 1:  # a fold takes as much room as a line
        hidden, above = 0, len(pairs)
    for i, j in pairs[:above]:
        yield DiffRow("same", _side(left, i), _side(right, j))
    if hidden:
        yield DiffRow("folded", hidden=hidden)
        for i, j in pairs[len(pairs) - below :] if below else ():
            yield DiffRow("same", _side(left, i), _side(right, j))


def _side(lines: Sequence[str], place: int | None) -> NumberedLine | None:
    if place is None:
        return None
    text = lines[place]
    return NumberedLine(place + 1, text if len(text) <= MAX_LINE_LENGTH else text[:MAX_LINE_LENGTH] + CUT)
