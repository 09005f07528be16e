"""The faults of the objectives of a course."""

from __future__ import annotations

import pytest

from server.authoring.objectives import find_objective_faults
from server.course.practice import practised_objectives
from tests.support.quick import the_course
from tests.support.small_course import CourseFolder
from tests.support.texts_on_disk import FRONT

OBJECTIVE = '[[objective]]\nid = "{id}"\ntext = "Doubler."\nshort = "Doubler"\n{rest}\n'


def found(course_folder: CourseFolder, *entries: str) -> list[tuple[str, int | None, str]]:
    head = FRONT.format(slug="une", order=10).removesuffix("+++\n")
    course_folder.write("curriculum/m9/seances/une.md", head + "".join(entries) + "+++\nDu texte.\n")
    course = course_folder.load(render=False)
    assert course.problems == ()
    return [(problem.path.name, problem.line, problem.message) for problem in find_objective_faults(course)]


def entry(rest: str, id: str = "doubler") -> str:
    return OBJECTIVE.format(id=id, rest=rest)


@pytest.mark.parametrize(
    ("entries", "expected"),
    [
        ([], []),
        ([entry('exercises = ["a", "b"]')], []),
        ([entry('exercises = ["a:double", "b"]')], []),
        ([entry('exercises = ["a", "b", "tripler"]')], [("une.md", 10, "exercice inconnu « tripler »")]),
        ([entry('exercises = ["a:triple", "b"]')], [("une.md", 10, "n’a pas de fonction « triple »")]),
        (
            [entry('exercises = ["a", "b"]\nmistakes = ["a/perdue"]')],
            [("une.md", 11, "n’a pas d’erreur « perdue »")],
        ),
        (
            [entry('exercises = ["a", "b"]'), entry('exercises = ["a", "b"]')],
            [("une.md", 12, "un autre objectif se nomme déjà « doubler »")],
        ),
    ],
    ids=["none", "whole", "function", "exercise", "unknown function", "unknown mistake", "same id"],
)
def test_faults_have_their_line(
    course_folder: CourseFolder, entries: list[str], expected: list[tuple[str, int, str]]
) -> None:
    problems = found(course_folder, *entries)
    assert [problem[:2] for problem in problems] == [problem[:2] for problem in expected]
    assert all(message in problem[2] for problem, (_, _, message) in zip(problems, expected, strict=True))


def test_an_exercise_without_objective_is_a_fault(course_folder: CourseFolder) -> None:
    ((name, _, message),) = found(course_folder, entry('exercises = ["a"]'))
    assert name == "exercise.toml"
    assert "aucun objectif ne nomme l’exercice « b »" in message


def test_the_objectives_of_the_course_carry_all_exercises_and_mistakes() -> None:
    course = the_course()
    assert [*find_objective_faults(course)] == []
    assert all(len(practised_objectives(module)) >= 5 for module in course.modules.values())
