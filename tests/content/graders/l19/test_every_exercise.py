"""The solution and honest styles of each exercise of l19 pass."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.quick import one_in
from tests.support.shipped import CODE
from tests.support.verdicts import verdict_of

EXERCISES = [exercise for exercise in CODE if exercise.startswith("l19/")]
STYLES = [
    case
    for exercise in EXERCISES
    for case in one_in(4, [(exercise, path) for path in sorted((CODE[exercise].folder / "specimens/ok").glob("*.py"))])
]


def test_there_are_five() -> None:
    assert len(EXERCISES) == 5


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("exercise", EXERCISES)
def test_the_solution_gets_full_marks(exercise: str, seed: int) -> None:
    assert verdict_of(exercise, CODE[exercise].solution, seed).score == 1.0


@pytest.mark.parametrize(("exercise", "path"), STYLES, ids=lambda one: getattr(one, "stem", one))
def test_honest_styles_pass(exercise: str, path: Path) -> None:
    assert verdict_of(exercise, path.read_text(encoding="utf-8"), 1).score == 1.0
