"""What is said of an attempt whose mistake has no name: the first check that it fails, in words."""

from __future__ import annotations

import pytest

from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.board.failed_checks import find_first_failed_check
from server.course import Course
from server.desk.lesson.stuck_rows import failure_words
from tests.support.service import EXERCISE


def check(title: str, cause: Outcome | None = None, *, passed: bool = False, repeats: str | None = None) -> CheckResult:
    return CheckResult(title, title, passed, 5.0 if passed else 0.0, 5.0, cause=cause, repeats=repeats)


@pytest.mark.parametrize(
    ("outcome", "checks", "words"),
    [
        (Outcome.WRONG_ANSWER, [check("Un", passed=True), check("Deux"), check("Trois")], "Échoue : « Deux »"),
        (Outcome.WRONG_ANSWER, [check("Un", repeats="Deux"), check("Deux")], "Échoue : « Deux »"),
        (Outcome.RUNTIME_ERROR, [check("Un", Outcome.RUNTIME_ERROR)], "Erreur à l’exécution : « Un »"),
        (Outcome.RUNTIME_ERROR, [check("Un"), check("Deux", Outcome.RUNTIME_ERROR)], "Échoue : « Un »"),
        (Outcome.SYNTAX_ERROR, [check("Un", Outcome.SYNTAX_ERROR)], "Erreur de syntaxe"),
    ],
)
def test_the_first_failed_check_is_named(
    course: Course, outcome: Outcome, checks: list[CheckResult], words: str
) -> None:
    failure = find_first_failed_check(Verdict(EXERCISE, "v1", outcome, 1, checks))
    assert failure_words(course, EXERCISE, failure) == words
