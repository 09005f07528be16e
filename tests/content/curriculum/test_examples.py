"""The calls that an exercise offers to begin from: read as if they were typed, and answered by its solution."""

from __future__ import annotations

import pytest

from graders.core.code.grading import CodeGrader
from graders.core.contract.streams import stream
from server.course import Exercise
from server.course.reuse import build_importable_library
from server.sandbox import Kit, Sandbox
from server.steps import calls
from tests.support.quick import one_in, some, the_course
from tests.support.shipped import CODE


def offered() -> list[Exercise]:
    return some(one for one in the_course().exercises.values() if any(function.example for function in one.functions))


def test_an_example_is_a_call_of_its_function_and_short_enough_for_its_field() -> None:
    for exercise in offered():
        for function in exercise.functions:
            if function.example:
                call = calls.parse_call(function.example)
                assert call.function == function.name, exercise.id
                assert not function.is_class
                assert len(function.example) <= 300


@pytest.mark.parametrize("name", one_in(4, CODE))
def test_the_solution_answers_the_examples(course_sandbox: Sandbox, name: str) -> None:
    exercise = the_course().exercises[name]
    assert isinstance(exercise.grader, CodeGrader)
    found = exercise.grader.kit(stream(1, "kit"))
    kit = Kit(found.module, dict(found.parameters), found.without, build_importable_library(the_course(), exercise.id))
    for function in exercise.functions:
        if function.example:
            call = calls.parse_call(function.example)
            with course_sandbox.open(exercise.solution.encode(), kit=kit, policy=exercise.policy) as session:
                assert session.call(call.function, *call.arguments).value is not None, function.name
