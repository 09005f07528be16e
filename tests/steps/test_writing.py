"""Values of a trace, written for a page without scripts as Python writes them."""

from __future__ import annotations

import pytest

from server.steps.schemas import ArrayOut, OtherOut, SequenceOut, TextOut, Value
from server.steps.writing import format_traced_value


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (ArrayOut(dtype="float64", shape=[2, 2], values=["1.0", "2.0", "3.0", "4.0"], cut=False),
         "array([[1.0, 2.0], [3.0, 4.0]])"),
        (ArrayOut(dtype="float64", shape=[900], values=["1.0", "2.0"], cut=True), "array([1.0, 2.0, …])"),
        (ArrayOut(dtype="float64", shape=[], values=["1.0"], cut=False), "array(1.0)"),
        (ArrayOut(dtype="float64", shape=[0, 3], values=[], cut=False), "array([])"),
        (SequenceOut(type="tuple", items=[TextOut(text="a", length=1)], length=1), "('a',)"),
        (SequenceOut(type="list", items=[TextOut(text="ab", length=9)], length=4), "['ab'…, …]"),
        (SequenceOut(type="deque", items=[], length=0), "deque([])"),
        (OtherOut(type="function", name="f"), "<function f>"),
    ],
)  # fmt: skip
def test_a_value_is_written_as_python_does_and_says_what_was_cut(value: Value, text: str) -> None:
    assert format_traced_value(value) == text
