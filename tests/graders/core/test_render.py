"""What students read: French numbers, and strict JSON."""

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.compare import words as render


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.5, "1,5"),
        (-2, "−2"),
        (math.pi / 2, "π/2"),
        (-3 * math.pi / 4, "−3π/4"),
        (math.pi, "π"),
        (6.1e-17, "0"),
        (1e-6, "1 × 10^−6"),
        (0.1 + 0.2, "0,3"),
        (float("nan"), "nan"),
        (-(10**400), "environ −10^400"),
        (-math.inf, "−∞"),
        (123456789, "123456789"),
    ],
)
def test_numbers_are_french(value: float, text: str) -> None:
    assert render.number(value) == text


def test_values_are_one_line() -> None:
    assert render.text(np.array([1.0, 2.5])) == "[1 ; 2,5]"
    assert render.text((1, [True, None])) == "(1, [True, None])"
    assert render.text(np.zeros((9, 9))) == "un tableau de forme (9, 9)"
    assert len(render.text("x" * 10_000)) <= render.MAX_TEXT


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.complex_numbers() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@given(values)
def test_everything_becomes_strict_json(value: object) -> None:
    json.dumps(render.to_jsonable(value), allow_nan=False)


def test_large_arrays_are_summed_up() -> None:
    assert render.to_jsonable(np.zeros((30, 40)))["forme"] == [30, 40]


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_counterexamples_keep_all_digits(value: float) -> None:
    assert json.loads(json.dumps(render.to_jsonable(np.float64(value)))) == value
