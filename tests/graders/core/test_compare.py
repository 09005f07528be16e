"""Comparators: generous about containers, strict about content, never raising on what a student returned."""

import math
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.compare.comparison import CloseTo, SameIndices, ScalarCloseTo
from graders.core.compare.slips import SLIPS
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import MAX_COMPACT_BYTES, MAX_READ_ONE_BY_ONE, ValueDigest, compact_value, same_value
from graders.robotics.poses import SamePose

plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.complex_numbers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.tuples(inner, inner) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=12,
)
arrays = st.sampled_from(
    [np.zeros(0), np.zeros((3, 1)), np.array(1.0), np.array([np.nan] * 3), np.array([True, False, True]),
     np.array(["a", "b", "c"]), np.array([1 + 1j, 0, 0]), np.full(3, np.inf), np.zeros((2, 0, 3))]
)  # fmt: skip


@given(plain | arrays)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_no_value_makes_a_comparator_raise(value: object) -> None:
    for compare, expected in (
        (CloseTo(), np.array([1.0, 2.0, 3.0])),
        (ScalarCloseTo(), 1.5),
        (SamePose(), np.array([1.0, 2.0, 3.0])),
        (SameIndices(), [1, 2]),
    ):
        mismatch = compare(expected, value)
        if mismatch is not None:
            assert mismatch.message
            assert mismatch.slip is None or mismatch.slip in SLIPS


@pytest.mark.parametrize("value", [[1, 2, 3.0], (1, 2, 3), np.array([1, 2, 3]), np.array([1, 2, 3], dtype=np.float32)])
def test_lists_tuples_and_arrays_are_read_alike(value: object) -> None:
    assert CloseTo()(np.array([1.0, 2.0, 3.0]), value) is None


@pytest.mark.parametrize("value", [2, 2.0, np.float64(2), np.array(2.0), np.int64(2), True + True])
def test_a_numpy_scalar_or_a_0d_array_is_a_float(value: object) -> None:
    assert ScalarCloseTo()(2.0, value) is None


@given(st.floats(-3.1, 3.1), st.integers(-3, 3))
def test_pose_angle_counts_modulo_a_turn_but_must_be_in_range(theta: float, turns: int) -> None:
    mismatch = SamePose()(np.array([0.0, 0.0, theta]), [0.0, 0.0, theta + turns * math.tau])
    assert (mismatch is None) == (turns == 0)
    if mismatch is not None:
        assert mismatch.slip == "angle_non_ramene"


def test_both_half_turns_are_accepted() -> None:
    for theta in (math.pi, -math.pi, math.pi + 5e-10, -math.pi - 5e-10):
        assert SamePose()(np.array([0.0, 0.0, math.pi]), [0, 0, theta]) is None
    assert SamePose()(np.array([0.0, 0.0, math.pi]), [0, 0, math.pi + 1e-8]) is not None


def test_tolerance_is_relative_or_absolute() -> None:
    assert CloseTo()(np.array([1e6]), [1e6 + 5e-4]) is None
    assert CloseTo()(np.array([1e6]), [1e6 + 5e-3]) is not None
    assert CloseTo()(np.array([0.0]), [9e-10]) is None
    assert CloseTo()(np.array([0.0]), [2e-9]) is not None


@pytest.mark.parametrize(
    ("value", "slip"),
    [
        (np.array([[1.0, 3.0], [2.0, 4.0]]), "transposee"),
        (-np.array([[1.0, 2.0], [3.0, 4.0]]), "oppose"),
        (np.full((2, 2), np.nan), "nan"),
        (np.zeros((2, 3)), "forme"),
        (3.0, "scalaire"),
    ],
)
def test_usual_slips_are_named(value: object, slip: str) -> None:
    mismatch = CloseTo()(np.array([[1.0, 2.0], [3.0, 4.0]]), value)
    assert mismatch is not None
    assert mismatch.slip == slip


@pytest.mark.parametrize("value", [None, "abc", {"a": 1}, [[1], [2, 3]], [1j, 2, 3], ["1", "2", "3"]])
def test_what_is_no_number_is_an_invalid_output(value: object) -> None:
    mismatch = CloseTo()(np.array([1.0, 2.0, 3.0]), value)
    assert mismatch is not None
    assert mismatch.cause is Outcome.INVALID_OUTPUT


def test_indices_say_what_is_missing_and_what_is_extra() -> None:
    same = SameIndices()
    assert same([1, 4], np.array([1, 4])) is None
    assert same([1, 4], [1.0, 4.0]) is None
    assert same([], []) is None
    missing = same([1, 4], [1, 5])
    assert missing is not None
    assert "4" in missing.message
    assert "5" in missing.message
    order = same([1, 4], [4, 1])
    assert order is not None
    assert "ordre" in order.message


@given(plain | arrays, plain | arrays)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_any_two_values_are_the_same_or_not(left: object, right: object) -> None:
    assert same_value(left, right) is same_value(right, left)


def test_values_of_any_kind_are_the_same_as_their_copies() -> None:
    pair = np.empty(2, dtype=object)
    pair[:] = [np.eye(2), np.zeros(2)]
    for value in (pair, np.array([1j, 2.0]), 3 + 1j, "x", {"a": pair}, [pair, None]):
        assert same_value(value, deepcopy(value))
    assert not same_value(pair, pair[::-1])
    assert not same_value(np.array([1j]), np.array([2j]))


@pytest.mark.parametrize("held", [lambda x: x, lambda x: {"x": x}, lambda x: (np.eye(2), x), lambda x: [x, "a"]])
def test_values_in_tuples_and_dictionaries_are_compared_up_to_the_same_tolerance(held: Callable[[float], Any]) -> None:
    assert not same_value(held(1.0), held(1.0 + 1e-9), tolerance=0.0)
    assert same_value(held(1.0), held(1.01), tolerance=0.1)


def test_a_text_is_never_the_same_as_an_array() -> None:
    assert same_value("x", np.zeros(3)) is False
    assert same_value(None, np.zeros(3)) is False


@given(plain | arrays, plain | arrays, st.booleans())
def test_what_is_kept_of_two_values_is_the_same_when_they_are(first: object, other: object, again: bool) -> None:
    if again:
        other = first
    assert same_value(compact_value(first), compact_value(other)) == same_value(first, other)


@pytest.mark.parametrize(
    "value",
    [
        [[0.5] * 100] * 100,
        np.zeros(MAX_COMPACT_BYTES // 8 + 1),
        "x" * (MAX_COMPACT_BYTES + 1),
        {"k" * MAX_COMPACT_BYTES: 1},
        [[0.5], [1, 2]] * 1000,
        [np.zeros(0), np.zeros(1)] * 1000,
    ],
    ids=["rows", "array", "text", "key", "ragged", "arrays"],
)
def test_of_a_value_that_is_too_big_a_digest_is_kept(value: object) -> None:
    digest = compact_value(value)
    assert isinstance(digest, ValueDigest)
    assert same_value(digest, compact_value(value))
    assert not same_value(digest, compact_value([value, 1]))
    assert not same_value(digest, compact_value([1.0, 2.0]))


def test_more_indices_than_there_can_be_are_not_read() -> None:
    mismatch = SameIndices()([1, 2], np.ones(MAX_READ_ONE_BY_ONE + 1, dtype=np.uint8))
    assert mismatch is not None
    assert mismatch.cause is Outcome.INVALID_OUTPUT
    assert str(MAX_READ_ONE_BY_ONE + 1) in mismatch.message
