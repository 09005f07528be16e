"""What `balise check` proves of the course, in the real sandbox, on seeds that do not change."""

import itertools
from collections.abc import Iterator
from dataclasses import replace
from unittest.mock import patch

import pytest

from graders.core.code.grading import CodeGrader
from graders.core.contract.outcomes import Outcome
from server.cli import check
from server.cli.check import Case, cases, examine
from server.course import Exercise
from server.grading.joint import Grader
from server.sandbox import Sandbox
from tests.support.quick import the_course

pytestmark = pytest.mark.long

COURSE = the_course()
KNOWN = [(exercise, case) for exercise in COURSE.exercises.values() for case in cases(exercise)]


#: What ends before any check is run.
AT_ONCE = ("spécimen syntax_error", "spécimen import_error", "spécimen missing_function")


def quick(exercise: Exercise) -> Iterator[str]:
    """The subjects of the fast suite: of code, one of each kind, and one in six of the mistakes that are whole files.

    Right programs, and the mistakes that are but edits of a model, are tried there in this process, which is quicker;
    the sandbox treats them as it does the reference. Nor does it run there what takes seconds each time.
    """
    subjects = [case.subject for case in cases(exercise)]
    if not isinstance(exercise.grader, CodeGrader):
        yield from subjects
        return
    if exercise.grader.long:
        yield from (one for one in subjects if one.startswith(AT_ONCE))
        return
    edits = {f"erreur {one.id}" for one in exercise.grader.misconceptions if not one.whole}
    tried = [one for one in subjects if one not in edits and not one.startswith(f"spécimen {Outcome.OK}/")]
    for kind, group in itertools.groupby(tried, key=lambda one: one.split("/" if "/" in one else None)[0]):
        yield from itertools.islice(group, 0, None if kind == "erreur" else 1, 6)


QUICK = {(exercise.id, subject) for exercise in COURSE.exercises.values() for subject in quick(exercise)}
PARAMETERS = [
    pytest.param(
        exercise, case, id=f"{exercise.id}-{case.subject}",
        marks=[] if (exercise.id, case.subject) in QUICK else [pytest.mark.slow],
    )
    for exercise, case in KNOWN
]  # fmt: skip


@pytest.fixture(scope="module")
def grader(course_sandbox: Sandbox) -> Iterator[Grader]:
    with patch.object(check, "ENDLESS_SECONDS", 0.1):  # what never ends is stopped all the same
        yield Grader(COURSE, course_sandbox)


def test_the_course_has_its_exercises_and_no_problem() -> None:
    first = {"poses", "predire2d", "reechantillonnage", "boucles", "kabsch", "slam_graphe"}
    assert {f"l20/{slug}" for slug in first} <= COURSE.exercises.keys()
    assert COURSE.problems == ()


@pytest.mark.parametrize(("exercise", "case"), PARAMETERS)
def test_solutions_pass_starters_do_not_and_mistakes_are_named(exercise: Exercise, case: Case, grader: Grader) -> None:
    assert examine(grader, exercise, case, seed=2026).fault == ""


@pytest.mark.slow
@pytest.mark.parametrize(("exercise", "case"), [(exercise, case) for exercise, case in KNOWN if case.endless])
def test_what_never_ends_is_ended_by_its_exercise_s_own_limit(exercise: Exercise, case: Case, grader: Grader) -> None:
    assert examine(grader, exercise, replace(case, endless=False), seed=2026).fault == ""


@pytest.mark.parametrize("name", COURSE.exercises)
def test_every_exercise_knows_several_mistakes(name: str) -> None:
    exercise = COURSE.exercises[name]
    assert len(exercise.grader.mistakes()) >= {"code": 6, "answers": 3}[exercise.kind]
