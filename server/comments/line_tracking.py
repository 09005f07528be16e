"""Where what was said of some lines stands in a later text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from server.comments.difference import DiffRun, LineDiff


class LineFate(StrEnum):
    """What became of lines: they are the same; some of them were changed; they are not to be found."""

    carried = "carried"
    changed = "changed"
    removed = "gone"


@dataclass(frozen=True)
class LineRange:
    """Lines, from 1, both included."""

    first: int
    last: int


@dataclass(frozen=True)
class TrackedLines:
    """`place` is None for lines that are gone."""

    fate: LineFate
    lines: LineRange | None


GONE = TrackedLines(LineFate.removed, None)


def track_lines(difference: LineDiff, place: LineRange) -> TrackedLines:
    """Where the lines of `place` stand after the difference.

    Lines that were replaced by as many stand one in the place of the other; by fewer or more, all in that of all.
    """
    asked = range(place.first - 1, place.last)
    found = [span for run in difference.runs for span in _after(run, asked, exact=difference.is_exact)]
    if not found:
        return GONE
    landed = LineRange(found[0].start + 1, found[-1].stop)
    whole = all(run.is_equal for run in difference.runs if _overlap(run.before, asked))
    same = whole and landed.last - landed.first == place.last - place.first
    return TrackedLines(LineFate.carried if same else LineFate.changed, landed)


def _after(run: DiffRun, asked: range, *, exact: bool) -> Iterator[range]:
    """The lines in which those that are asked for have ended, if any."""
    common = _overlap(run.before, asked)
    if not common or not run.after or not (run.is_equal or exact):
        return
    if len(run.before) == len(run.after):
        shift = run.after.start - run.before.start
        yield range(common.start + shift, common.stop + shift)
    else:
        yield run.after


def _overlap(one: range, other: range) -> range:
    return range(max(one.start, other.start), min(one.stop, other.stop))
