"""How often a right answer is waited for: what a submission costs beyond its own computing."""

from __future__ import annotations

import pytest

from server.course.models import Course
from server.grading.joint import Grader
from server.sandbox import Sandbox
from server.sandbox.wire import Wire


@pytest.mark.parametrize(("exercise", "most"), [("l20/poses", 3), ("l20/kabsch", 1)])
def test_a_right_answer_is_asked_few_questions(
    course_sandbox: Sandbox, course: Course, monkeypatch: pytest.MonkeyPatch, exercise: str, most: int
) -> None:
    asked = 0
    ask = Wire.ask

    def counted(wire: Wire, token: int, kind: int, payload: bytes, deadline: float) -> None:
        nonlocal asked
        asked += 1
        ask(wire, token, kind, payload, deadline)

    monkeypatch.setattr(Wire, "ask", counted)
    source = course.exercises[exercise].solution.encode()
    assert Grader(course, course_sandbox).grade(exercise, source, 5).verdict.score == 1
    assert asked == most
