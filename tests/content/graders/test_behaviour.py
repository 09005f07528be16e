"""What programs answer to the fixed questions of an exercise: kept within bounds, compared up to a tolerance."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graders.core.code.behaviour import BehaviourObserver
from graders.core.code.grading import CodeGrader
from graders.core.code.probes import TOLERANCE, ProbeFault
from graders.core.code.stored_answers import (
    MAX_ITEMS,
    PROJECTION_TOLERANCE,
    TOO_LARGE,
    deserialize_answers,
    project_to_number,
    same_answer,
    same_answers,
    serialize_answers,
    structure_hash,
    to_stored_answer,
)
from graders.core.contract.local import LOCAL
from tests.support.quick import only, the_course
from tests.support.shipped import CODE


def observer(exercise_id: str, version: str | None = None) -> BehaviourObserver:
    exercise = the_course().exercises[exercise_id]
    assert isinstance(exercise.grader, CodeGrader)
    return BehaviourObserver(exercise.grader, version or exercise.version)


NUMBERS = st.floats(allow_nan=True, allow_infinity=True, width=64)
VALUES: Any = st.recursive(
    NUMBERS | st.integers() | st.booleans() | st.none() | st.text(max_size=300) | st.complex_numbers(),
    lambda inner: (
        st.lists(inner, max_size=4) | st.tuples(inner, inner) | st.dictionaries(st.text(max_size=4), inner, max_size=3)
    ),
    max_leaves=12,
)


@given(VALUES)
def test_any_answer_is_kept_whole_and_is_the_same_as_itself(value: Any) -> None:
    kept = to_stored_answer(value)
    assert same_answer(kept, kept)
    (again,) = deserialize_answers(serialize_answers((kept,)))
    assert same_answer(kept, again, tolerance=0.0)
    assert structure_hash((kept,)) == structure_hash((again,))
    assert np.isfinite(project_to_number((kept,)))


@given(
    st.lists(st.floats(-1e300, 1e300), min_size=1, max_size=30),
    st.lists(st.floats(-1.0, 1.0), min_size=30, max_size=30),
)
def test_answers_that_are_the_same_are_found_by_structure_and_projection(
    numbers: list[float], shifts: list[float]
) -> None:
    """The search never passes over a group whose representative is the same."""
    one = np.array(numbers)
    other = one + np.array(shifts[: len(numbers)]) * TOLERANCE * (1.0 + np.abs(one)) * 0.99
    assert same_answer(to_stored_answer(one), to_stored_answer(other)) or same_answer(
        to_stored_answer(other), to_stored_answer(one)
    )
    assert structure_hash((to_stored_answer(one),)) == structure_hash((to_stored_answer(list(other)),))
    assert (
        abs(project_to_number((to_stored_answer(one),)) - project_to_number((to_stored_answer(other),)))
        < PROJECTION_TOLERANCE
    )


def test_what_is_told_apart() -> None:
    different = [
        0.0, 1.0, [0.0], [[0.0]], [0.0, 0.0], "0", None, ProbeFault("TypeError"), ProbeFault("ValueError"),
        {"a": 0.0}, {"b": 0.0}, (np.zeros(2), np.zeros((2, 2))), [1.0, "a"],
        float("nan"), float("inf"), -float("inf"), 1j, 2j,
    ]  # fmt: skip
    kept = [to_stored_answer(one) for one in different]
    assert not [(a, b) for k, a in enumerate(different) for b in range(k) if same_answer(to_stored_answer(a), kept[b])]
    assert same_answer(to_stored_answer(True), to_stored_answer(np.float64(1.0)))
    assert same_answer(to_stored_answer([1.0, 2.0]), to_stored_answer(np.array([1, 2])))
    assert to_stored_answer(np.zeros(MAX_ITEMS)) == to_stored_answer([[0.0] * MAX_ITEMS]) == TOO_LARGE
    assert len(serialize_answers((to_stored_answer("x" * 10**6),))) < 1000


@pytest.mark.parametrize("exercise_id", CODE)
def test_every_exercise_of_code_has_its_questions_and_its_solution_answers_them(exercise_id: str) -> None:
    exercise = the_course().exercises[exercise_id]
    asked = observer(exercise_id)
    functions = {series.function for series in asked.all_series}
    assert functions == {one.name for one in exercise.functions}
    solution = exercise.solution.encode()
    behaviour = asked.observe(solution, LOCAL)
    assert behaviour.is_loadable
    assert not behaviour.lacks_function
    assert same_answers(behaviour.answers, observer(exercise_id).observe(solution, LOCAL).answers)
    assert len(serialize_answers(behaviour.answers)) < 10_000
    starter = asked.observe(exercise.starter.encode(), LOCAL)
    assert starter.shows_mistake
    assert starter.example is not None
    assert starter.example.function in functions


@pytest.mark.parametrize("exercise_id", only(["l20/poses"], CODE))
def test_misconceptions_behave_each_in_its_own_way(exercise_id: str) -> None:
    """Every catalogued mistake is seen, and but for mistakes that no input of the exercise tells apart, told apart."""
    grader = CODE[exercise_id]
    assert isinstance(grader, CodeGrader)
    asked = observer(exercise_id)
    found = [(one.id, asked.observe(one.source.encode(), LOCAL)) for one in grader.misconceptions]
    assert all(behaviour.shows_mistake for _, behaviour in found)
    alike = [
        (name, other)
        for k, (name, one) in enumerate(found)
        for other, two in found[:k]
        if name != other and same_answers(one.answers, two.answers)
    ]
    assert len(alike) <= 1, alike


def test_a_function_without_probes_is_asked_what_the_checks_ask_the_solution() -> None:
    exercise = the_course().exercises["l20/poses"]
    assert isinstance(exercise.grader, CodeGrader)
    bare = replace(exercise.grader, prober=None)
    asked, again, other = BehaviourObserver(bare, "v1"), BehaviourObserver(bare, "v1"), BehaviourObserver(bare, "v2")
    assert {one.function for one in asked.all_series} == {"composer", "inverse", "relatif"}
    wrong = exercise.solution.replace("ramener(ta + tb)", "ta + tb").encode()
    behaviour = asked.observe(wrong, LOCAL)
    assert behaviour.functions == ("composer", "relatif")
    assert same_answers(behaviour.answers, again.observe(wrong, LOCAL).answers)
    assert not same_answers(behaviour.answers, other.observe(wrong, LOCAL).answers), "another version draws otherwise"
    assert not asked.observe(exercise.solution.encode(), LOCAL).wrong


def test_an_argument_written_on_is_seen() -> None:
    exercise = the_course().exercises["l20/poses"]
    writes = exercise.solution.replace("    x, y, t = a\n", "    x, y, t = a\n    a[0] = 7.0\n")
    behaviour = observer("l20/poses").observe(writes.encode(), LOCAL)
    assert behaviour.functions == ("inverse", "relatif"), "the second calls the first"
    assert behaviour.example is not None
    assert behaviour.example.expected != behaviour.example.got
    assert behaviour.example.got[0] == 7.0
