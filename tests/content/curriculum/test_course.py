"""The course, as `balise check` proves it: all of it in one slow test.

The fast suite proves of each exercise that its reference passes, that its starter does not, and that every mistake of
its catalogue is caught; and that mistakes are named in the sandbox, of one exercise for each template. Texts have their
own file, `test_texts.py`.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from graders.core.code.folder import Misconception
from graders.core.code.grading import CodeGrader
from graders.core.contract.local import LOCAL
from server.base.files import ROOT
from server.cli import check
from server.cli.check import KnownCase, examine_case, list_cases
from server.course import Course, Exercise
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox
from tests.support.shipped import CODE, exercises_of_kind
from tests.support.verdicts import checked

SEED = 2026
#: Every case of this one runs in the fast suite: each outcome, in the sandbox, with the limits of an exercise.
COMPLETE = "l20/poses"
#: One on the template with SciPy, whose first mistake that is a whole file is named in the sandbox too.
WITH_SCIPY = "l20/slam_graphe"
#: Caught only by fifteen whole runs, which take a third of the time of all mistakes together; left to `balise check`.
LONG_MISTAKES = {"injection_au_meme_endroit"}


def fast_cases(exercise: Exercise) -> Sequence[KnownCase]:
    """The reference of an exercise of code, on one seed; of one exercise for each template, a mistake that is named.

    Each reference is graded in the sandbox, with the limits of its exercise. Tests of the exercises name their mistakes
    without it.
    """
    known = [replace(case, rounds=1) for case in list_cases(exercise)]
    grader = exercise.grader
    if exercise.id == COMPLETE or not isinstance(grader, CodeGrader):
        return known
    if exercise.id != WITH_SCIPY:
        return known[:1]
    whole = {f"erreur {mistake.id}" for mistake in grader.misconceptions if mistake.whole}
    return [known[0], next(case for case in known if case.subject in whole)]


@pytest.fixture(scope="module")
def grader(course: Course, course_sandbox: Sandbox) -> Iterator[SandboxGrader]:
    with patch.object(check, "ENDLESS_SECONDS", 0.1):  # what never ends is stopped all the same
        yield SandboxGrader(course, course_sandbox)


def test_the_course_has_its_exercises_and_no_problem(course: Course) -> None:
    first = {"poses", "predire2d", "reechantillonnage", "boucles", "kabsch", "slam_graphe"}
    assert {f"l20/{slug}" for slug in first} <= course.exercises.keys()
    assert course.problems == ()
    assert course.exercises.keys() == {*exercises_of_kind("code"), *exercises_of_kind("answers")}


@pytest.mark.long
@pytest.mark.parametrize("name", [*exercises_of_kind("code"), *exercises_of_kind("answers")])
def test_the_reference_passes_and_a_mistake_is_named(name: str, course: Course, grader: SandboxGrader) -> None:
    exercise = course.exercises[name]
    examined = [examine_case(grader, exercise, case, SEED) for case in fast_cases(exercise)]
    assert [examination for examination in examined if examination.fault] == []


@pytest.mark.parametrize("name", CODE)
def test_the_starter_earns_nothing(name: str, course: Course) -> None:
    verdict = checked(name, course.exercises[name].starter, SEED).verdict
    assert verdict.outcome.counts
    assert verdict.score == 0.0


@pytest.mark.parametrize("name", CODE)
def test_every_known_mistake_is_caught(name: str) -> None:
    """By a check, the first of those that fail: in this process, without simplifying or naming it."""
    grader = CODE[name]
    with np.errstate(all="ignore"):
        known = [mistake for mistake in grader.misconceptions if mistake.id not in LONG_MISTAKES]
        passing = [mistake.id for mistake in known if not is_caught(grader, mistake)]
    assert passing == []


def is_caught(grader: CodeGrader, mistake: Misconception) -> bool:
    """Whether a check fails; those of the mistake's own functions are asked first, alone before together."""
    own = {*mistake.functions}
    checks = sorted(grader.checks, key=lambda check: (own.isdisjoint(check.functions), len(check.functions)))
    return grader.first_failed_check(mistake.source.encode(), LOCAL, seed=SEED, checks=checks) is not None


@pytest.mark.slow
@pytest.mark.long
def test_balise_check_finds_the_whole_course_in_order() -> None:
    """All texts, figures, cells, replays, solutions, starters, mistakes and specimens, in the real sandbox."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("BALISE_")}
    command = [sys.executable, "-m", "server", "check", "--fresh"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, "\n".join(line for line in done.stdout.splitlines() if not line.startswith("✓"))


@pytest.mark.slow
def test_what_never_ends_is_ended_by_the_limit_of_its_exercise(course: Course, grader: SandboxGrader) -> None:
    known = [
        (exercise, case) for exercise in course.exercises.values() for case in list_cases(exercise) if case.endless
    ]
    assert known
    examined = [examine_case(grader, exercise, replace(case, endless=False), SEED) for exercise, case in known]
    assert [examination for examination in examined if examination.fault] == []


def test_every_exercise_knows_several_mistakes(course: Course) -> None:
    least = {"code": 6, "answers": 3}
    known = {
        name: len(exercise.grader.mistake_ids()) - least[exercise.kind] for name, exercise in course.exercises.items()
    }
    assert min(known.values()) >= 0, known
