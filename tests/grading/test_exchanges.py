"""How often a right answer is waited for: what a submission costs beyond its own computing."""

from __future__ import annotations

import pytest

from graders.core.code.grading import CodeGrader
from graders.core.code.places import is_worth_searching
from server.course.models import Course
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox
from server.sandbox.wire import Wire


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """The tokens of the questions that wires carry."""
    asked: list[int] = []
    ask = Wire.send

    def counted(wire: Wire, token: int, kind: int, payload: bytes, deadline: float) -> None:
        asked.append(token)
        ask(wire, token, kind, payload, deadline)

    monkeypatch.setattr(Wire, "send", counted)
    return asked


@pytest.mark.parametrize(("exercise", "most"), [("l20/poses", 3), ("l20/kabsch", 1), ("l20/predire2d", 20)])
def test_a_right_answer_is_asked_few_questions(
    course_sandbox: Sandbox, course: Course, asked: list[int], exercise: str, most: int
) -> None:
    source = course.exercises[exercise].solution.encode()
    assert SandboxGrader(course, course_sandbox).grade(exercise, source, 5).verdict.score == 1
    assert len(asked) == most


def test_a_wrong_answer_is_asked_few_more(course_sandbox: Sandbox, course: Course, asked: list[int]) -> None:
    """What four checks failed on is simplified in three or four exchanges, and what names it is one more."""
    grader = course.exercises["l20/poses"].grader
    assert isinstance(grader, CodeGrader)
    mistake = grader.misconceptions[0]
    verdict = SandboxGrader(course, course_sandbox).grade("l20/poses", mistake.source.encode(), 5).verdict
    assert verdict.diagnosis is not None
    assert verdict.diagnosis.id == mistake.id
    assert len(asked) <= 8


def test_an_index_that_is_no_integer_is_told_and_taken_for_no_mistake_of_the_catalogue(
    course: Course, course_sandbox: Sandbox
) -> None:
    exercise = "l20/reechantillonnage"
    source = """
def n_eff(poids):
    return 1 / np.sum(poids**2)

def reechantillonner_systematique(particules, poids):
    fins = np.cumsum(poids)
    copies = particules.copy()
    for k in range(len(poids)):
        i = np.floor(np.sum(fins < rng.random()) + 0.0)
        copies[k] = particules[i]
    return copies
"""
    verdict = SandboxGrader(course, course_sandbox).grade(exercise, source.encode(), 5).verdict
    assert verdict.diagnosis is None
    assert any("Un indice doit être un nombre entier" in check.message for check in verdict.checks)
    assert not is_worth_searching(verdict)
