"""Two texts side by side: rows to show, the long runs that did not change folded, within bounds."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, zip_longest
from typing import Literal

from server.comments.difference import Run, compare, lines_of

CONTEXT = 3
MOST_ROWS = 600
LONGEST_LINE = 300
CUT = " …"

Kind = Literal["same", "changed", "removed", "added", "folded"]


@dataclass(frozen=True)
class Side:
    """A line, with its number from 1; cut where it is very long."""

    number: int
    text: str


@dataclass(frozen=True)
class Row:
    """A line before and after; None where there is none. `folded` rows stand for `hidden` lines of both."""

    kind: Kind
    before: Side | None = None
    after: Side | None = None
    hidden: int = 0


@dataclass(frozen=True)
class Beside:
    """`added` and `removed` count lines. `exact` as in `Difference`; `whole`: no row was left out at the end."""

    rows: tuple[Row, ...]
    added: int
    removed: int
    exact: bool
    whole: bool


def beside(before: str, after: str) -> Beside:
    left, right = lines_of(before), lines_of(after)
    difference = compare(left, right)
    rows = tuple(islice(_rows(difference.runs, left, right), MOST_ROWS + 1))
    changed = [run for run in difference.runs if not run.kept]
    return Beside(
        rows=rows[:MOST_ROWS],
        added=sum(len(run.after) for run in changed),
        removed=sum(len(run.before) for run in changed),
        exact=difference.exact,
        whole=len(rows) <= MOST_ROWS,
    )


def _rows(runs: Sequence[Run], left: Sequence[str], right: Sequence[str]) -> Iterator[Row]:
    for place, run in enumerate(runs):
        if run.kept:
            yield from _kept(run, left, right, is_first=place == 0, is_last=place == len(runs) - 1)
        else:
            for i, j in zip_longest(run.before, run.after):
                kind: Kind = "added" if i is None else "removed" if j is None else "changed"
                yield Row(kind, _side(left, i), _side(right, j))


def _kept(run: Run, left: Sequence[str], right: Sequence[str], *, is_first: bool, is_last: bool) -> Iterator[Row]:
    above, below = 0 if is_first else CONTEXT, 0 if is_last else CONTEXT
    pairs = list(zip(run.before, run.after, strict=True))
    hidden = len(pairs) - above - below
    if hidden <= 1:  # a fold takes as much room as a line
        hidden, above = 0, len(pairs)
    for i, j in pairs[:above]:
        yield Row("same", _side(left, i), _side(right, j))
    if hidden:
        yield Row("folded", hidden=hidden)
        for i, j in pairs[len(pairs) - below :] if below else ():
            yield Row("same", _side(left, i), _side(right, j))


def _side(lines: Sequence[str], place: int | None) -> Side | None:
    if place is None:
        return None
    text = lines[place]
    return Side(place + 1, text if len(text) <= LONGEST_LINE else text[:LONGEST_LINE] + CUT)
