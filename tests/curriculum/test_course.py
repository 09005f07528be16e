"""What `balise check` proves of the course, in the real sandbox, on seeds that do not change."""

import pytest

from graders.core.code.grading import CodeGrader
from server.cli.check import Case, cases, examine
from server.course import Exercise
from server.grading.joint import Grader
from server.sandbox import Sandbox
from tests.support.quick import the_course

pytestmark = pytest.mark.long

COURSE = the_course()
KNOWN = [(exercise, case) for exercise in COURSE.exercises.values() for case in cases(exercise)]


def edits(exercise: Exercise) -> set[str]:
    """The subjects of the mistakes that are but edits of a model, which a test of the probes recognises quicker."""
    grader = exercise.grader
    mistakes = grader.misconceptions if isinstance(grader, CodeGrader) else ()
    return {f"erreur {one.id}" for one in mistakes if not one.whole}


PARAMETERS = [
    pytest.param(
        exercise, case, id=f"{exercise.id}-{case.subject}",
        marks=[pytest.mark.slow] if case.subject in edits(exercise) else [],
    )
    for exercise, case in KNOWN
]  # fmt: skip


@pytest.fixture(scope="module")
def grader(course_sandbox: Sandbox) -> Grader:
    return Grader(COURSE, course_sandbox)


def test_the_course_has_its_exercises_and_no_problem() -> None:
    first = {"poses", "predire2d", "reechantillonnage", "boucles", "kabsch", "slam_graphe"}
    assert {f"l20/{slug}" for slug in first} <= COURSE.exercises.keys()
    assert COURSE.problems == ()


@pytest.mark.parametrize(("exercise", "case"), PARAMETERS)
def test_solutions_pass_starters_do_not_and_mistakes_are_named(exercise: Exercise, case: Case, grader: Grader) -> None:
    assert examine(grader, exercise, case, seed=2026).fault == ""


@pytest.mark.parametrize("name", COURSE.exercises)
def test_every_exercise_knows_several_mistakes(name: str) -> None:
    exercise = COURSE.exercises[name]
    assert len(exercise.grader.mistakes()) >= {"code": 6, "answers": 3}[exercise.kind]
