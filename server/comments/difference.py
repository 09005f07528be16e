"""Line diff of two texts, with bounded work on any texts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

#: Bounds on the part between the common beginning and end. Beyond either, lines are not matched: `difflib` examines
#: each pair of equal lines again for each run that it finds.
MAX_DIFF_LINES = 500
MAX_EQUAL_PAIRS = 6000


@dataclass(frozen=True)
class DiffRun:
    """Lines of the text before and the lines that replace them, as ranges from 0; equal where `is_equal`."""

    is_equal: bool
    before: range
    after: range


@dataclass(frozen=True)
class LineDiff:
    """Runs that cover both texts in order. `is_exact`: all lines were matched, within the bounds."""

    runs: tuple[DiffRun, ...]
    is_exact: bool = True


def split_lines(code: str) -> list[str]:
    """Split code into its numbered lines; a final end of line begins no other line."""
    lines = code.replace("\r\n", "\n").split("\n")
    return lines[:-1] if len(lines) > 1 and not lines[-1] else lines


def diff_lines(before: Sequence[str], after: Sequence[str]) -> LineDiff:
    """Diff two texts in linear time, plus the matching that `MAX_DIFF_LINES` and `MAX_EQUAL_PAIRS` allow."""
    head = _count_equal_prefix(zip(before, after, strict=False))
    shorter = min(len(before), len(after)) - head
    tail = min(shorter, _count_equal_prefix(zip(reversed(before), reversed(after), strict=False)))
    left, right = before[head : len(before) - tail], after[head : len(after) - tail]
    runs = [DiffRun(True, range(head), range(head))]
    exact = _is_small_enough_to_match(left, right)
    if exact:
        matcher = SequenceMatcher(None, left, right, autojunk=False)
        runs += [
            DiffRun(tag == "equal", range(head + i, head + j), range(head + m, head + n))
            for tag, i, j, m, n in matcher.get_opcodes()
        ]
    else:
        runs.append(DiffRun(False, range(head, len(before) - tail), range(head, len(after) - tail)))
    runs.append(DiffRun(True, range(len(before) - tail, len(before)), range(len(after) - tail, len(after))))
    return LineDiff(tuple(run for run in runs if run.before or run.after), exact)


def _count_equal_prefix(pairs: Iterator[tuple[str, str]]) -> int:
    """Count the pairs before the first pair of different lines."""
    count = 0
    for left, right in pairs:
        if left != right:
            break
        count += 1
    return count


def _is_small_enough_to_match(left: Sequence[str], right: Sequence[str]) -> bool:
    if not left or not right:
        return True
    if max(len(left), len(right)) > MAX_DIFF_LINES:
        return False
    times = Counter(right)
    return sum(count * times[line] for line, count in Counter(left).items()) <= MAX_EQUAL_PAIRS
