"""Two numbers shown together: whatever they are, their texts tell them apart, and by how much."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st

from graders.core.compare.told_apart import (
    angle_text_pair,
    gap_text,
    got_instead_of_expected_text,
    number_text_pair,
    remove_noise_from_pair,
    value_text_pair,
)

floats = st.floats(allow_nan=False)
near = st.tuples(st.floats(-1e6, 1e6), st.integers(-300, 300)).map(
    lambda pair: (pair[0], pair[0] + pair[1] * np.spacing(pair[0]))
)


@given(st.one_of(st.tuples(floats, floats), near), st.integers(2, 8))
@example((math.pi / 2, 1.5707963), 6)
@example((math.pi, math.pi + 1e-13), 6)
@example((math.pi, -math.pi), 6)
@example((0.0, 5e-14), 6)
@example((5e-324, 0.0), 6)
@example((0.9999999, 1.0), 6)
@example((1e300, 1.0000000000000002e300), 6)
@example((math.inf, 1.7976931348623157e308), 6)
def test_two_different_numbers_have_different_texts(pair: tuple[float, float], digits: int) -> None:
    assume(pair[0] != pair[1])
    left, right = number_text_pair(*pair, digits)
    assert left != right
    assert number_text_pair(pair[1], pair[0], digits) == (right, left)
    assert value_text_pair(pair[0], pair[1])[0] != value_text_pair(pair[0], pair[1])[1]
    vectors = value_text_pair(np.array([1.0, pair[0]]), [1.0, pair[1]])
    assert vectors[0] != vectors[1]
    nested = value_text_pair(({"R": [[pair[0]]]}, 2), ({"R": [[pair[1]]]}, 2))
    assert nested[0] != nested[1]
    expected, got = remove_noise_from_pair([pair[0], 2.0], [pair[1], 2.0])
    assert expected != got


@given(st.tuples(st.floats(-10, 10), st.floats(-10, 10)) | near)
def test_two_different_angles_have_different_texts(pair: tuple[float, float]) -> None:
    assume(pair[0] != pair[1])
    left, right = angle_text_pair(*pair)
    assert left != right


@given(st.integers(-(10**40), 10**40), st.integers(-2, 2))
def test_two_different_integers_have_different_texts(value: int, step: int) -> None:
    assume(step)
    assert len(set(number_text_pair(value, value + step))) == 2
    assert len(set(number_text_pair(value, float(value)))) == 2


@pytest.mark.parametrize(
    ("value", "other", "texts"),
    [
        (0.0, -0.0, ("0,0", "−0,0")),
        (1, 1.0, ("1 (entier)", "1 (flottant)")),
        (np.float32(0.5), 0.5, ("0,5 (float32)", "0,5 (flottant)")),
        (2.5, 2.5, ("2,5", "2,5")),
        (math.nan, math.nan, ("nan", "nan")),
        (0.1, np.float32(0.1), ("0,1", "0,1000000015")),
        (math.pi / 2, 1.5707963, ("π/2 ≈ 1,570796327", "1,5707963")),
        (math.pi, -math.pi, ("π", "−π")),
        (0.0, 5e-14, ("0", "5 × 10^−14")),
    ],
)
def test_numbers_that_print_alike(value: Any, other: Any, texts: tuple[str, str]) -> None:
    assert number_text_pair(value, other) == texts


def test_a_list_has_more_digits_where_they_are_needed_only() -> None:
    noise = 1.0 + 2.0**-52
    assert value_text_pair([0.1234567, 1.0, 2.0], [0.12345671, noise, 2.0]) == (
        "[0,1234567 ; 1 ; 2]",
        "[0,12345671 ; 1 ; 2]",
    )
    assert value_text_pair([1.0], [noise])[0] != value_text_pair([1.0], [noise])[1]


@pytest.mark.parametrize(
    ("expected", "got", "told"),
    [
        (1 - math.pi, 1 + math.pi - 2 * 3.14159265, "à 7·10⁻⁹ près, comme si π valait 3,14159265"),
        (math.pi / 2, 3.14159 / 2, "à 1·10⁻⁶ près, comme si π valait 3,14159"),
        (1.2345678912, float(np.float32(1.2345678912)), "comme en simple précision (float32)"),
        (1.23456789, 1.234568, "à 1·10⁻⁷ près, comme arrondi à 6 décimales"),
        (1.0, 1.0 + 2.0**-50, "par les arrondis du calcul"),
        (1.0, 1.1, ""),
        (1.0, 1.0, ""),
    ],
)
def test_the_gap_is_told_with_its_usual_cause(expected: float, got: float, told: str) -> None:
    assert told in gap_text(expected, got) if told else gap_text(expected, got) == ""


def test_the_sentence_tells_both_and_the_gap() -> None:
    assert got_instead_of_expected_text(1.0, 0.99999974) == "0,99999974 au lieu de 1 (à 3·10⁻⁷ près)"
    assert got_instead_of_expected_text(2.0, 3.0) == "3 au lieu de 2"


def test_rounding_noise_is_tidied_unless_it_is_all_there_is() -> None:
    assert remove_noise_from_pair([0.0, 1.0], [6.1e-17, 2.0]) == ([0.0, 1.0], [0.0, 2.0])
    assert remove_noise_from_pair([0.0], [6.1e-17]) == ([0.0], [6.1e-17])


@pytest.mark.parametrize("hold", [np.array, np.float64, lambda it: [np.array(it)]])
def test_numbers_in_arrays_without_axes_are_told_apart(hold: Any) -> None:
    left, right = value_text_pair(hold(1.0), hold(1.000003))
    assert left != right
