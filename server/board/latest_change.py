"""The change from one attempt to the next: pure."""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.answers.reading import UnreadableAnswersError, read_answers
from server.comments.difference import DiffRun, diff_lines, split_lines

MAX_LENGTH = 60
CUT = "…"


@dataclass(frozen=True)
class LatestChange:
    """The first change: its `line` from 1 in the later program, shortened texts; `others` counts further lines.

    Without code, `line` is None and `others` counts the changed answers.
    """

    line: int | None
    before: str
    after: str
    others: int


def compare_attempts(before: bytes, after: bytes, *, is_code: bool) -> LatestChange | None:
    """Return the change from one attempt to the next; None where nothing but blanks changed."""
    if not is_code:
        changed = _count_changed_answers(before, after)
        return LatestChange(None, "", "", changed) if changed else None
    left, right = _lines(before), _lines(after)
    runs = [run for run in diff_lines(left, right).runs if not run.is_equal and _has_text(run, left, right)]
    if not runs:
        return None
    first = runs[0]
    return LatestChange(
        line=first.after.start + 1,
        before=_first_text(left, first.before),
        after=_first_text(right, first.after),
        others=sum(max(len(run.before), len(run.after)) for run in runs) - 1,
    )


def _lines(source: bytes) -> list[str]:
    text = source.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    return [line.rstrip() for line in split_lines(text)]


def _has_text(run: DiffRun, left: list[str], right: list[str]) -> bool:
    return any(left[index] for index in run.before) or any(right[index] for index in run.after)


def _first_text(lines: list[str], indices: range) -> str:
    """Return the first line that is not empty, shortened."""
    text = next((lines[index].strip() for index in indices if lines[index]), "")
    return text if len(text) <= MAX_LENGTH else text[: MAX_LENGTH - 1] + CUT


def _count_changed_answers(before: bytes, after: bytes) -> int:
    try:
        old, new = read_answers(before), read_answers(after)
    except UnreadableAnswersError:
        return 0
    return sum(old.get(name) != new.get(name) for name in old.keys() | new.keys())
