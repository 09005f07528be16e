"""Track commented lines from one text to a later one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from server.comments.difference import DiffRun, LineDiff


class LineFate(StrEnum):
    """Whether tracked lines are the same, partly changed, or gone."""

    carried = "carried"
    changed = "changed"
    gone = "gone"


@dataclass(frozen=True)
class LineRange:
    """A range of lines, numbered from 1, both ends included."""

    first: int
    last: int


@dataclass(frozen=True)
class TrackedLines:
    """The fate of tracked lines and their range in the later text, None where they are gone."""

    fate: LineFate
    lines: LineRange | None


GONE = TrackedLines(LineFate.gone, None)


def track_lines(diff: LineDiff, lines: LineRange) -> TrackedLines:
    """Return where `lines` stand after the diff.

    Lines replaced by as many map one to one; replaced by fewer or more, they map to the whole replacement.
    """
    tracked = range(lines.first - 1, lines.last)
    spans = [span for run in diff.runs for span in _iter_mapped_ranges(run, tracked, is_exact=diff.is_exact)]
    if not spans:
        return GONE
    moved = LineRange(spans[0].start + 1, spans[-1].stop)
    unchanged = all(run.is_equal for run in diff.runs if _range_overlap(run.before, tracked))
    same = unchanged and moved.last - moved.first == lines.last - lines.first
    return TrackedLines(LineFate.carried if same else LineFate.changed, moved)


def _iter_mapped_ranges(run: DiffRun, tracked: range, *, is_exact: bool) -> Iterator[range]:
    """Yield the later lines of a run that the tracked lines map to."""
    common = _range_overlap(run.before, tracked)
    if not common or not run.after or not (run.is_equal or is_exact):
        return
    if len(run.before) == len(run.after):
        shift = run.after.start - run.before.start
        yield range(common.start + shift, common.stop + shift)
    else:
        yield run.after


def _range_overlap(left: range, right: range) -> range:
    return range(max(left.start, right.start), min(left.stop, right.stop))
