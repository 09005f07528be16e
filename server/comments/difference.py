"""How one text became the next, line by line, within bounded work whatever the texts are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

#: Beyond either, between what two texts begin and end with in common, lines are not matched: `difflib` looks at each
#: pair of equal lines again for each run that it finds.
MAX_DIFF_LINES = 500
MAX_EQUAL_PAIRS = 6000


@dataclass(frozen=True)
class DiffRun:
    """Lines of the text before, and those that stand in their place after (from 0, the end not included)."""

    is_equal: bool
    before: range
    after: range


@dataclass(frozen=True)
class LineDiff:
    """Runs that cover both texts in order. `exact`: each line that stayed was looked for."""

    runs: tuple[DiffRun, ...]
    is_exact: bool = True


def split_lines(code: str) -> list[str]:
    """The lines as they are numbered: an end of line at the end begins no other."""
    lines = code.replace("\r\n", "\n").split("\n")
    return lines[:-1] if len(lines) > 1 and not lines[-1] else lines


def diff_lines(before: Sequence[str], after: Sequence[str]) -> LineDiff:
    """What became of each line. Costs at most one look at each line, and what `MOST_LINES`, `MOST_PAIRS` allow."""
    head = _common(zip(before, after, strict=False))
    shorter = min(len(before), len(after)) - head
    tail = min(shorter, _common(zip(reversed(before), reversed(after), strict=False)))
    left, right = before[head : len(before) - tail], after[head : len(after) - tail]
    runs = [DiffRun(True, range(head), range(head))]
    exact = _is_small(left, right)
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


def _common(pairs: Iterator[tuple[str, str]]) -> int:
    """How many pairs there are before the first of different lines."""
    count = 0
    for one, other in pairs:
        if one != other:
            break
        count += 1
    return count


def _is_small(left: Sequence[str], right: Sequence[str]) -> bool:
    if not left or not right:
        return True
    if max(len(left), len(right)) > MAX_DIFF_LINES:
        return False
    times = Counter(right)
    return sum(count * times[line] for line, count in Counter(left).items()) <= MAX_EQUAL_PAIRS
