"""What a figure of `Cases` is made from: an answer that can be drawn, in the shape of what is expected, or nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from graders.core.code.checks import Cases
from graders.core.compare.comparison import CloseTo

PAIR = (np.zeros(2), np.eye(2))


def drawn(expected: Any, got: Any, **changes: Any) -> Any:
    """What the figure of a check is handed as the answer."""
    figure = {"figure": lambda args, right, answer: {"got": answer}}
    check = Cases(
        id="c", title="t", points=20, functions=("f",), hint="h", names=("x",), cases=lambda rng: [(1.0,)],
        expected=lambda x: expected, compare=CloseTo(), **figure | changes,
    )  # fmt: skip
    return check.figure_data((1.0,), expected, got)


def test_a_pair_of_arrays_is_drawn_item_by_item() -> None:
    got = drawn(PAIR, [[1, 2], np.ones((2, 2))])["got"]
    assert isinstance(got, tuple)
    assert [one.tolist() for one in got] == [[1.0, 2.0], [[1.0, 1.0], [1.0, 1.0]]]


@pytest.mark.parametrize(
    "got",
    [None, 3.0, "xy", (np.zeros(2),), (np.zeros(2), np.eye(3)), (np.zeros(2), None), (np.eye(2), np.zeros(2)),
     (np.full(2, np.inf), np.eye(2)), {"x": 1.0}],
)  # fmt: skip
def test_what_is_no_such_pair_is_not_drawn(got: Any) -> None:
    assert drawn(PAIR, got) == {"got": None}


def test_a_pair_of_numbers_is_an_array_of_two() -> None:
    assert drawn((1.0, 2.0), [3, 4])["got"].tolist() == [3.0, 4.0]


def test_a_figure_may_have_nothing_to_draw() -> None:
    assert drawn(1.0, 2.0, figure=lambda args, right, answer: None) is None
    assert drawn(1.0, 2.0, figure=None) is None
