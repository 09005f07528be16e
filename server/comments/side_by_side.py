"""Side-by-side view of two texts: a bounded number of rows, with long unchanged runs folded."""

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
    """A line with its number from 1, truncated where it is very long."""

    number: int
    text: str


@dataclass(frozen=True)
class DiffRow:
    """A line before and after; None where there is none. A `folded` row stands for `hidden` unchanged lines."""

    kind: Kind
    before: NumberedLine | None = None
    after: NumberedLine | None = None
    hidden: int = 0


@dataclass(frozen=True)
class SideBySide:
    """`added` and `removed` count lines. `is_exact` as in `LineDiff`; `is_complete`: no row is left out at the end."""

    rows: tuple[DiffRow, ...]
    added: int
    removed: int
    is_exact: bool
    is_complete: bool


def compare_side_by_side(before: str, after: str) -> SideBySide:
    left, right = split_lines(before), split_lines(after)
    diff = diff_lines(left, right)
    rows = tuple(islice(_build_diff_rows(diff.runs, left, right), MAX_ROWS + 1))
    changed = [run for run in diff.runs if not run.is_equal]
    return SideBySide(
        rows=rows[:MAX_ROWS],
        added=sum(len(run.after) for run in changed),
        removed=sum(len(run.before) for run in changed),
        is_exact=diff.is_exact,
        is_complete=len(rows) <= MAX_ROWS,
    )


def _build_diff_rows(runs: Sequence[DiffRun], left: Sequence[str], right: Sequence[str]) -> Iterator[DiffRow]:
    for index, run in enumerate(runs):
        if run.is_equal:
            yield from _build_context_rows(run, left, right, is_first=index == 0, is_last=index == len(runs) - 1)
        else:
            for i, j in zip_longest(run.before, run.after):
                kind: Kind = "added" if i is None else "removed" if j is None else "changed"
                yield DiffRow(kind, _build_numbered_line(left, i), _build_numbered_line(right, j))


def _build_context_rows(
    run: DiffRun, left: Sequence[str], right: Sequence[str], *, is_first: bool, is_last: bool
) -> Iterator[DiffRow]:
    above, below = 0 if is_first else CONTEXT, 0 if is_last else CONTEXT
    pairs = list(zip(run.before, run.after, strict=True))
    hidden = len(pairs) - above - below
    if hidden <= 1:  # a fold takes as much room as a line
        hidden, above = 0, len(pairs)
    for i, j in pairs[:above]:
        yield DiffRow("same", _build_numbered_line(left, i), _build_numbered_line(right, j))
    if hidden:
        yield DiffRow("folded", hidden=hidden)
        for i, j in pairs[len(pairs) - below :] if below else ():
            yield DiffRow("same", _build_numbered_line(left, i), _build_numbered_line(right, j))


def _build_numbered_line(lines: Sequence[str], index: int | None) -> NumberedLine | None:
    if index is None:
        return None
    text = lines[index]
    return NumberedLine(index + 1, text if len(text) <= MAX_LINE_LENGTH else text[:MAX_LINE_LENGTH] + CUT)
