"""Answers without code, the hostile ones: files that are none, values of any kind, and what must not leak."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from graders.core.contract.outcomes import Outcome
from tests.support.answered import ODOMETRY, PROOF, QUIZ, graded, grader_of
from tests.support.tables import folded

#: One exercise of each form: numbers, choices and an order. Exercises of a form differ by their texts and data alone.
FORMS = (ODOMETRY, QUIZ, PROOF)
MALFORMED = {
    b"": Outcome.SYNTAX_ERROR,
    b"[]": Outcome.SYNTAX_ERROR,
    b"null": Outcome.SYNTAX_ERROR,
    b"12": Outcome.SYNTAX_ERROR,
    b"{": Outcome.SYNTAX_ERROR,
    b"\xff\xfe": Outcome.SYNTAX_ERROR,
    b'{"a": 1, "a": 2}': Outcome.SYNTAX_ERROR,
    b"[" * 60_000: Outcome.SYNTAX_ERROR,
    b'{"a":' * 9_000: Outcome.SYNTAX_ERROR,
    b'{"a": "' + b"x" * 70_000 + b'"}': Outcome.SYNTAX_ERROR,
    b"{}": Outcome.INVALID_OUTPUT,
    b"\xef\xbb\xbf{}": Outcome.INVALID_OUTPUT,
    b'{"inconnue": 1}': Outcome.INVALID_OUTPUT,
}


@folded("name", FORMS)
@folded("source", MALFORMED, ids=lambda source: repr(source[:12]))
def test_a_malformed_file_has_its_outcome_and_no_mark(name: str, source: bytes) -> None:
    verdict = graded(name, source).verdict
    assert (verdict.outcome, verdict.score) == (MALFORMED[source], 0)
    assert all(check.message for check in verdict.checks)


@pytest.mark.parametrize("name", FORMS)
def test_one_unknown_question_spoils_even_right_answers(name: str) -> None:
    verdict = graded(name, {**grader_of(name).right_answers(7), "\ud800zut`<b>": 1}).verdict
    assert (verdict.outcome, verdict.score) == (Outcome.INVALID_OUTPUT, 0)
    assert "zut" not in verdict.checks[0].message
    json.dumps(verdict.to_json(), ensure_ascii=False).encode()


HOSTILE = [
    True, False, [], {}, [[]], {"a": 1}, "\ud800", "\x00", "1\x00", "x" * 5000, "1" * 5000, -1, 3.5, ["a", "a"],
    ["a", 1], [["a"]], [None], ["z"], ["\ud800"], "zz", "A", "a b", list("abcdefghijklmnopqrstuvwxyz"),
    ["a"] * 5000, 10**400,
]  # fmt: skip


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize("value", HOSTILE, ids=lambda value: repr(value)[:30])
def test_values_of_any_kind_are_judged_never_raised(name: str, value: Any) -> None:
    grader = grader_of(name)
    right = dict(grader.right_answers(7))
    for question in grader.paper(7).questions:
        source = json.dumps({**right, question.id: value}).encode()
        verdict = grader.grade(source, seed=7, version="v").verdict
        assert verdict.outcome in {Outcome.INVALID_OUTPUT, Outcome.WRONG_ANSWER, Outcome.OK}
        json.dumps(verdict.to_json(), allow_nan=False, ensure_ascii=False).encode()
        grader.transcribe({**right, question.id: value}, 7)
        grader.translate_letters({**right, question.id: value}, 7, 8)


@pytest.mark.parametrize("name", FORMS)
@pytest.mark.parametrize(
    "literal", ["NaN", "Infinity", "-Infinity", "1e999", "-1e999", "1" * 4000, "[" * 900 + "]" * 900]
)
def test_numbers_that_are_none_and_deep_lists_are_unreadable(name: str, literal: str) -> None:
    for question in grader_of(name).paper(7).questions:
        source = f'{{"{question.id}": {literal}}}'.encode()
        verdict = graded(name, source).verdict
        assert verdict.outcome in {Outcome.INVALID_OUTPUT, Outcome.SYNTAX_ERROR}
        json.dumps(verdict.to_json(), allow_nan=False)


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8) | st.sampled_from("abcdefghij"),
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(st.text(max_size=4), inner, max_size=4),
    max_leaves=12,
)


#: Answers to questions, by their number, and to what is none.
ANSWERS = st.dictionaries(st.integers(0, 11) | st.text(max_size=3), ANYTHING, max_size=9)


@hypothesis_settings(max_examples=30, deadline=None)
@given(drawn=ANSWERS, seed=st.integers(0, 2**53 - 1))
def test_nothing_that_json_holds_breaks_a_grader(drawn: dict[int | str, Any], seed: int) -> None:
    """The same answers are given to all of them: to invent them takes longer than to judge them."""
    for name in FORMS:
        names = [question.id for question in grader_of(name).paper(seed).questions]
        answers = {names[key % len(names)] if isinstance(key, int) else key: one for key, one in drawn.items()}
        grading = graded(name, json.dumps(answers).encode(), seed)
        text = json.dumps(grading.verdict.to_json(), allow_nan=False, ensure_ascii=False).encode()
        assert 0 <= grading.verdict.score <= 1, name
        assert len(text) < 60_000, name


@hypothesis_settings(max_examples=100, deadline=None)
@given(st.binary(max_size=200))
def test_nothing_that_bytes_hold_breaks_the_grader(source: bytes) -> None:
    assert graded(QUIZ, source).verdict.score <= 1


def test_timings_do_not_depend_on_what_is_right() -> None:
    """One number in all, of the whole grading: none for a question."""
    timings = graded(QUIZ, grader_of(QUIZ).right_answers(7)).verdict.timings
    assert list(timings) == ["total_ms"]
    assert math.isfinite(timings["total_ms"])
