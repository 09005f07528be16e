"""The change from one attempt to the next: pure."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import takewhile
from textwrap import dedent

from graders.core.answers.reading import UnreadableAnswersError, read_answers
from server.comments.difference import DiffRun, diff_lines, split_lines

MAX_LENGTH = 60
LEAD = 12  # characters that are shown before the difference of two long lines
CUT = "…"


@dataclass(frozen=True)
class LatestChange:
    """The first change: its `line` from 1 in the later program, and the two texts; `others` counts further lines.

    Long lines are shortened around their difference. Two lines are indented as they are to each other.

    Without code, `line` is None and `others` counts the changed answers.
    """

    line: int | None
    before: str
    after: str
    others: int


def find_change_between(before: bytes, after: bytes, *, is_code: bool) -> LatestChange | None:
    """Return the change from one attempt to the next; None where nothing but blanks changed."""
    if not is_code:
        changed = _count_changed_answers(before, after)
        return LatestChange(None, "", "", changed) if changed else None
    left, right = _decode_lines(before), _decode_lines(after)
    runs = [run for run in diff_lines(left, right).runs if not run.is_equal and _has_nonblank_line(run, left, right)]
    if not runs:
        return None
    first = runs[0]
    old, new = _shorten_pair_around_difference(
        _first_nonblank_line(left, first.before), _first_nonblank_line(right, first.after)
    )
    return LatestChange(
        line=first.after.start + 1,
        before=old,
        after=new,
        others=sum(max(len(run.before), len(run.after)) for run in runs) - 1,
    )


def _decode_lines(source: bytes) -> list[str]:
    text = source.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    return [line.rstrip() for line in split_lines(text)]


def _has_nonblank_line(run: DiffRun, left: list[str], right: list[str]) -> bool:
    return any(left[index] for index in run.before) or any(right[index] for index in run.after)


def _first_nonblank_line(lines: list[str], indices: range) -> str:
    """Return the first line that is not empty."""
    return next((lines[index] for index in indices if lines[index]), "")


def _shorten_pair_around_difference(before: str, after: str) -> tuple[str, str]:
    """Return two lines without their common indentation, shortened so that their difference stays."""
    before, after = dedent(f"{before}\n{after}").split("\n") if before and after else (before.strip(), after.strip())
    start = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(before, after, strict=False)))
    return _shorten_around(before, start), _shorten_around(after, start)


def _shorten_around(text: str, start: int) -> str:
    """Return a line, or the part of a long one around a column."""
    if len(text) <= MAX_LENGTH:
        return text
    room = MAX_LENGTH - 2 * len(CUT)
    first = max(0, min(start - LEAD, len(text) - room))
    if first <= len(CUT):
        return text[: MAX_LENGTH - len(CUT)] + CUT
    part = text[first : first + room]
    return CUT + part + (CUT if first + room < len(text) else "")


def _count_changed_answers(before: bytes, after: bytes) -> int:
    try:
        old, new = read_answers(before), read_answers(after)
    except UnreadableAnswersError:
        return 0
    return sum(old.get(name) != new.get(name) for name in old.keys() | new.keys())
