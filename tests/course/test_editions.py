"""Modules by their names: where they stand in the course, and what `balise check` takes them for."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import pytest

from server.cli import CommandError
from server.cli.check import _select_modules_and_exercises
from server.course import Course
from server.course.editions import module_number_of_slug
from server.reading.service import build_home_view
from tests.support.quick import the_course


def test_a_module_stands_where_its_number_says() -> None:
    assert [module_number_of_slug(slug) for slug in ("l19", "l20e2", "maths7")] == [19, 20, 7]


def test_a_module_is_checked_whole_by_its_name() -> None:
    course = the_course()
    module = course.modules["l20"]
    other = replace(module, slug="l21", exercises=())
    both = Course(MappingProxyType({"l20": module, "l21": other}), ())
    assert _select_modules_and_exercises(both, ["l20", "l20/poses"]) == ([module], list(module.exercises))
    assert _select_modules_and_exercises(both, ["l20/poses"]) == ([], [course.exercises["l20/poses"]])
    assert _select_modules_and_exercises(both, [])[0] == [module, other]
    with pytest.raises(CommandError, match="l22"):
        _select_modules_and_exercises(both, ["l22"])


def test_neighbours_that_are_served_are_linked() -> None:
    module = replace(the_course().modules["l20"], previous="L19", next="L21")
    around = build_home_view(module, {}, (), {"L19": "/l19"}).around
    assert [(one.word, one.number, one.href) for one in around] == [("après", "L19", "/l19"), ("avant", "L21", "")]
