"""The number reader: what a student types, and whatever else."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.answers.numbers import MAX_DEPTH, MAX_LENGTH, NotANumberError, check_finite, read_number
from graders.core.compare.words import number
from tests.support.tables import folded

READ = {
    "0,1": 0.1,
    "0.1": 0.1,
    ",5": 0.5,
    "3.": 3.0,
    " -2,5 ": -2.5,
    "−2,5": -2.5,
    "+4": 4.0,
    "--1": 1.0,
    "1/3": 1 / 3,
    "pi/2": math.pi / 2,
    "π": math.pi,
    "2π/3": 2 * math.pi / 3,
    "Pi": math.pi,
    "3e-3": 3e-3,
    "3E+2": 300.0,
    "4,7·10^-3": 4.7e-3,
    "4,7 × 10⁻³": 4.7e-3,
    "2**3": 8.0,
    "2^3^2": 512.0,
    "-2^2": -4.0,
    "sqrt(2)/2": math.sqrt(2) / 2,
    "√2/2": math.sqrt(2) / 2,
    "2√(2+7)": 6.0,
    "racine(4)": 2.0,
    "(0,13-0,10)/0,3": 0.1,
    "1 000,5": 1000.5,
    "12 345 678": 12345678.0,
    "1\u00a0000": 1000.0,
    "1\u202f000": 1000.0,
    "6÷4": 1.5,
    "2(3+4)": 14.0,
    "sin(0,3)": math.sin(0.3),
    "1,5 + 0,12*COS(0,7+0,05/2)": 1.5 + 0.12 * math.cos(0.725),
    "tan(pi/4)": 1.0,
    "2cos(0)": 2.0,
    "sin(0,3)^2+cos(0,3)**2": 1.0,
    "exp(-0,85)": math.exp(-0.85),
    "e^-0,85": math.exp(-0.85),
    "1/(1+e^(-2))": 1 / (1 + math.exp(-2)),
    "ln(0,3/0,7)": math.log(3 / 7),
    "log(0,3/0,7)": math.log(3 / 7),
    "log10(100)": 2.0,
    "-ln(2)": -math.log(2),
    "arctan(1)": math.pi / 4,
    "atan2(0,8;-0,6)": math.atan2(0.8, -0.6),
    "abs(-2)": 2.0,
    "4,7 x 10^-3": 4.7e-3,
    "π√2": math.pi * math.sqrt(2),
    "2^0,5": math.sqrt(2),
    "8^(1/3)": 2.0,
}
REFUSED = [
    "", " ", "abc", "nan", "inf", "NaN", "-Infinity", "0,1 rad", "12°", "1,000.5", "1.5.2", "1,2,3", "1 2", "10 00",
    "1/0", "0/0", "0^-1", "sqrt(-1)", "sqrt", "√", "1e999", "-1e999", "10^15*10", "2^301", "2^(1/0)",
    "9^300^300", "(-8)^(1/3)", "ln(0)", "ln(-1)", "asin(2)", "exp(1000)", "sin 2", "sin^2(1)", "sin", "cos()", "3e",
    "atan2(1)", "atan2(1;2;3)", "sin(1;2)", "1;2;", "logo(3)", "tan(pi/2)", "10^400", "2rad", "été", "log 10",
    "(-1)^(1e999-1e999)", "sin(1e999)", "x2", "1/2pi", "1/2(3)", "(", ")", "((1)", "(1))", "1+", "*2", "1//2", "1..",
    "10^", "0x10", "1_000",
    "١", "1;2",
    "__import__('os')", "lambda: 1", "1 if 1 else 2", "[1]", "1j", "\ud800", "\x00", "1\x00", "٣", "²", "5%",
]  # fmt: skip


@folded("text", READ)
def test_what_students_type_is_read(text: str) -> None:
    assert read_number(text) == pytest.approx(READ[text], rel=1e-15)


@folded("text", REFUSED)
def test_what_is_no_number_is_explained(text: str) -> None:
    with pytest.raises(NotANumberError) as refused:
        read_number(text)
    reason = str(refused.value)
    assert reason[0].islower() or reason[0] == "«"
    assert not reason.endswith(".")
    assert reason.isprintable()


@pytest.mark.parametrize(
    ("text", "word"), [("0,12 rad", "rad"), ("sinus(1)", "sinus"), ("2 * Thêta", "Thêta"), ("a" * 90, "a" * 20 + "…")]
)
def test_a_word_that_is_not_known_is_named_and_those_that_are_with_it(text: str, word: str) -> None:
    with pytest.raises(NotANumberError, match=f"« {word} » n'est pas connu.*sqrt, sin, cos"):
        read_number(text)


def test_length_and_depth_are_bounded() -> None:
    assert read_number("1" + "+1" * 49) == 50
    for text in ("1" * (MAX_LENGTH + 1), "(" * 49 + "1" + ")" * 49, "-" * 60 + "1", "2" + "^2" * 40, "√" * 60 + "2"):
        with pytest.raises(NotANumberError):
            read_number(text)
    assert read_number("-" * (MAX_DEPTH - 1) + "1") == -1


@given(st.text(max_size=120))
def test_whatever_is_typed_is_a_finite_number_or_refused(text: str) -> None:
    try:
        value = read_number(text)
    except NotANumberError:
        return
    assert math.isfinite(value)


ATOMS = st.sampled_from(
    [
        "1",
        "2,5",
        "pi",
        "e",
        "sqrt(2)",
        "ln(",
        "exp(",
        "tan",
        "atan2(",
        ";",
        "(",
        ")",
        "+",
        "-",
        "*",
        "/",
        "^",
        "√",
        "e5",
        " ",
        ",",
        "10",
        "0",
    ]
)


@given(st.lists(ATOMS, max_size=30).map("".join))
def test_whatever_is_calculated_is_a_finite_number_or_refused(text: str) -> None:
    try:
        value = read_number(text)
    except NotANumberError:
        return
    assert math.isfinite(value)


@given(st.floats(-1e14, 1e14))
def test_a_number_is_read_as_it_was_written(value: float) -> None:
    for text in (repr(value), f"{value:.17g}".replace(".", ",")):
        assert read_number(text) == value
    assert read_number(number(value)) == pytest.approx(value, rel=1e-5, abs=1e-12)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e16, -1e300])
def test_numbers_of_json_are_bounded_too(value: float) -> None:
    with pytest.raises(NotANumberError):
        check_finite(value)
