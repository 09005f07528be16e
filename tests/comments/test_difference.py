"""What became of lines from one attempt to the next: right where texts are small, bounded where they are hostile."""

from __future__ import annotations

from collections.abc import Callable
from difflib import SequenceMatcher
from functools import cache
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from server.comments import difference as module
from server.comments.difference import MAX_DIFF_LINES, MAX_EQUAL_PAIRS, diff_lines, split_lines
from server.comments.line_tracking import LineFate, LineRange, TrackedLines, track_lines
from server.comments.side_by_side import MAX_LINE_LENGTH, MAX_ROWS, compare_side_by_side

TEXTS = st.lists(st.sampled_from(["", "a", "b", "c", "d", "e = 1"]), max_size=12)
BEFORE = ["import numpy", "", "def f(x):", "    y = x + 1", "    return y", "", "def g(x):", "    return x"]

#: What is done to BEFORE, the lines that are looked for, and what must become of them.
CASES: list[tuple[str, Callable[[list[str]], list[str]], tuple[int, int], tuple[LineFate, tuple[int, int] | None]]] = [
    ("nothing", lambda a: a, (4, 5), (LineFate.carried, (4, 5))),
    ("lines above", lambda a: ["# mien", "", *a], (4, 5), (LineFate.carried, (6, 7))),
    ("lines below", lambda a: [*a, "", "print(f(1))"], (4, 4), (LineFate.carried, (4, 4))),
    ("lines above taken away", lambda a: a[2:], (3, 5), (LineFate.carried, (1, 3))),
    ("the line itself", lambda a: [*a[:3], "    y = x + 2", *a[4:]], (4, 4), (LineFate.changed, (4, 4))),
    ("one of them", lambda a: [*a[:3], "    y = x + 2", *a[4:]], (3, 5), (LineFate.changed, (3, 5))),
    ("a line between", lambda a: [*a[:4], "    y *= 2", *a[4:]], (4, 5), (LineFate.changed, (4, 6))),
    ("one line by two", lambda a: [*a[:3], "    z = x", "    y = z", *a[4:]], (4, 4), (LineFate.changed, (4, 5))),
    ("its end", lambda a: [*a[:4], *a[5:]], (4, 5), (LineFate.changed, (4, 4))),
    ("it is taken away", lambda a: [*a[:3], *a[5:]], (4, 5), (LineFate.gone, None)),
    ("all of it", lambda _: [], (1, 8), (LineFate.gone, None)),
]


@pytest.mark.parametrize(("edit", "lines", "expected"), [case[1:] for case in CASES], ids=[case[0] for case in CASES])
def test_lines_are_found_again(
    edit: Any, lines: tuple[int, int], expected: tuple[LineFate, tuple[int, int] | None]
) -> None:
    fate, place = expected
    found = track_lines(diff_lines(BEFORE, edit(BEFORE)), LineRange(*lines))
    assert found == TrackedLines(fate, LineRange(*place) if place else None)


@settings(max_examples=60, deadline=None)
@given(TEXTS, TEXTS)
def test_a_difference_tells_the_whole_of_both(before: list[str], after: list[str]) -> None:
    runs = diff_lines(before, after).runs
    assert [line for run in runs for line in run.before] == list(range(len(before)))
    assert [line for run in runs for line in run.after] == list(range(len(after)))
    for run in runs:
        if run.is_equal:
            assert [before[line] for line in run.before] == [after[line] for line in run.after]


@settings(max_examples=60, deadline=None)
@given(TEXTS, TEXTS, st.data())
def test_what_is_carried_reads_the_same(before: list[str], after: list[str], data: st.DataObject) -> None:
    if not before:
        return
    first = data.draw(st.integers(1, len(before)))
    last = data.draw(st.integers(first, len(before)))
    found = track_lines(diff_lines(before, after), LineRange(first, last))
    if found.lines is None:
        assert found.fate is LineFate.gone
        return
    assert 1 <= found.lines.first <= found.lines.last <= len(after)
    if found.fate is LineFate.carried:
        assert after[found.lines.first - 1 : found.lines.last] == before[first - 1 : last]


@settings(max_examples=50, deadline=None)
@given(TEXTS, TEXTS)
def test_side_by_side_gives_both_back(before: list[str], after: list[str]) -> None:
    """Against `difflib`'s own account of the same two texts, where nothing is folded."""
    shown = compare_side_by_side("\n".join(before) + "\n", "\n".join(after) + "\n")
    left, right = (split_lines("\n".join(text) + "\n") for text in (before, after))
    numbers = iter(shown.rows)
    at = [0, 0]
    for row in numbers:
        if row.kind == "folded":
            assert left[at[0] : at[0] + row.hidden] == right[at[1] : at[1] + row.hidden]
            at = [at[0] + row.hidden, at[1] + row.hidden]
            continue
        for side, lines, which in ((row.before, left, 0), (row.after, right, 1)):
            if side is not None:
                assert (side.number, side.text) == (at[which] + 1, lines[at[which]])
                at[which] += 1
        if row.kind == "same":
            assert row.before is not None
            assert row.after is not None
            assert row.before.text == row.after.text
    assert at == [len(left), len(right)]
    assert shown.added - shown.removed == len(right) - len(left)


HOSTILE = ("empty lines", "few lines again and again", "all different", "one long line", "nothing")


@cache
def _hostile() -> dict[str, tuple[str, str]]:
    """Texts of 256 KiB that would keep `difflib` at work for hours, and their neighbours."""
    dice, most = Random(1), 256 * 1024
    names = [f"{number:x}" for number in range(150)]  # each too rare to be set aside as frequent
    few = "\n".join(dice.choices(names, k=most // 3))[:most]
    other = "\n".join(dice.choices(names, k=most // 3))[:most]
    return {
        "empty lines": ("\n" * most, "x" + "\n" * (most - 2) + "y"),
        "few lines again and again": (few, other),
        "all different": ("\n".join(map(str, range(40_000))), "\n".join(map(str, range(40_000, 0, -1)))),
        "one long line": ("x" * most, "x" * (most - 1) + "y"),
        "nothing": (few, ""),
    }


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_texts_cost_what_small_ones_do(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, int, int]] = []

    class Watched(SequenceMatcher[Any]):
        def __init__(self, isjunk: None, a: Any, b: Any, *, autojunk: bool) -> None:
            pairs = sum(b.count(line) for line in a) if len(a) <= MAX_DIFF_LINES else -1
            asked.append((len(a), len(b), pairs))
            super().__init__(isjunk, a, b, autojunk=autojunk)

    monkeypatch.setattr(module, "SequenceMatcher", Watched)
    assert list(_hostile()) == list(HOSTILE)
    before, after = _hostile()[name]
    shown = compare_side_by_side(before, after)
    assert len(shown.rows) <= MAX_ROWS
    assert all(len(side.text) <= MAX_LINE_LENGTH + 2 for row in shown.rows for side in (row.before, row.after) if side)
    lines = split_lines(before)
    track_lines(diff_lines(lines, split_lines(after)), LineRange(1, len(lines)))
    for left, right, pairs in asked:
        assert not left or not right or (max(left, right) <= MAX_DIFF_LINES and 0 <= pairs <= MAX_EQUAL_PAIRS)


def test_what_was_not_compared_is_said_and_carries_nothing() -> None:
    before, after = [str(n) for n in range(MAX_DIFF_LINES + 1)], [str(-n) for n in range(1, MAX_DIFF_LINES + 5)]
    difference = diff_lines(before, after)
    assert not difference.is_exact
    assert track_lines(difference, LineRange(3, 4)) == TrackedLines(LineFate.gone, None)
    assert not compare_side_by_side("\n".join(before), "\n".join(after)).is_exact
    assert track_lines(diff_lines(["a", *before, "z"], ["a", *after, "z"]), LineRange(1, 1)) == TrackedLines(
        LineFate.carried, LineRange(1, 1)
    )
