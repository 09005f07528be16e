"""No exercise of code stands alone: contracts promise its functions, and a path of its module leads to it.

That an objective carries it is `tests/authoring/test_objectives.py`.
"""

from __future__ import annotations

import re

import pytest

from tests.support.quick import the_course
from tests.support.shipped import CODE

LINK = re.compile(r"\]\(exo:([\w-]+)\)")


@pytest.mark.parametrize("name", CODE)
def test_every_function_of_an_exercise_of_code_has_a_contract(name: str) -> None:
    functions = {function.name for function in the_course().exercises[name].functions}
    assert {contract.function for contract in CODE[name].contracts} == functions


def test_a_path_leads_to_every_exercise_of_code() -> None:
    """Where a module has no paths, one of its lessons does."""
    for module in the_course().modules.values():
        pages = {path.page.partition("#")[0] for path in module.paths}
        lessons = [lesson for lesson in module.lessons if not pages or lesson.slug in pages]
        linked = {slug for lesson in lessons for slug in LINK.findall(lesson.text.source.text)}
        linked |= {slug for lesson in lessons for slug in lesson.text.exercises}
        coded = {exercise.slug for exercise in module.exercises if exercise.id in set(CODE)}
        assert coded <= linked, f"{module.slug}: {coded - linked}"
