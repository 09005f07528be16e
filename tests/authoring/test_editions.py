"""An edition is a module of its own, beside the first, and a class goes to it when its teacher says so."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest

from graders.core.contract.local import LOCAL
from server.authoring import editions
from server.authoring.new import SkeletonRefused
from server.course import Course, load_course
from server.course.editions import latest_editions, next_edition_slug, parse_edition
from server.web.editions import find_exercise_in_edition, list_editions_for_class_copy
from tests.support.outside import taken_in


def test_names_tell_the_edition() -> None:
    assert parse_edition("l21") == ("l21", 1)
    assert parse_edition("l21e12") == ("l21", 12)
    assert [next_edition_slug(slug) for slug in ("l21", "l21e2", "l21e9")] == ["l21e2", "l21e3", "l21e10"]
    assert latest_editions(["l21", "l21e10", "l21e9", "m2"]) == {"l21e10", "m2"}


def test_a_copied_module_holds_together_and_grades(place: Path, tmp_path: Path) -> None:
    course = tmp_path / "kalman"
    shutil.copytree(place, course, ignore=shutil.ignore_patterns("__pycache__"))
    with taken_in(course):
        files = editions.copy_to_next_edition("l21", course)
        assert all("l21" not in path.parts for path in (one.relative_to(course) for one in files))
        assert editions.copy_to_next_edition("l21", course)[0].relative_to(course).parts[1] == "l21e3"
        read = load_course(course / "curriculum", code=course, render=False)
        assert [one.message for one in read.problems if "n’a pas d’exercice" not in one.message] == []
        assert [module.slug for module in read.latest] == ["l21e3"]
        assert [one.slug for one in list_editions_for_class_copy(read, "l21e2")] == ["l21e2", "l21e3"]
        exercise = read.exercises["l21e2/gain"]
        judgement = exercise.grader.grade(exercise.grader.solution.encode(), LOCAL, seed=3, version="x")
        assert (judgement.verdict.exercise, judgement.verdict.score) == ("l21e2/gain", 1.0)
    with pytest.raises(SkeletonRefused):
        editions.copy_to_next_edition("l18", course)


def test_exercises_are_found_by_name_in_another_edition(course: Course) -> None:
    module = course.modules["l21"]
    kept = tuple(replace(one, module="l21e2") for one in module.exercises if one.slug != "gain")
    newer = replace(module, slug="l21e2", exercises=kept)
    both = Course(MappingProxyType({"l21": module, "l21e2": newer}), ())
    assert find_exercise_in_edition(both, "l21/calcul", "l21e2") == "l21e2/calcul"
    assert find_exercise_in_edition(both, "l21/gain", "l21e2") is None
    assert find_exercise_in_edition(both, "l21/gone", "l21") == "l21/gone"
    assert both.newer_edition("l21") is newer
    assert both.newer_edition("l21e2") is None
    assert newer.label == "L21, 2ᵉ édition"
