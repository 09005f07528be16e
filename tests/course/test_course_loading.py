"""Every malformation is reported with its place, and the other exercises still serve."""

from __future__ import annotations

from dataclasses import replace

import pytest

from graders.core.code.folder import Misconception
from graders.discovery import CourseProblem as GraderProblem
from graders.discovery import Discovery
from tests.support.small_course import EXERCISE, HINTS, CourseFolder, definition


def test_a_well_formed_course_has_no_problem(course_folder: CourseFolder) -> None:
    course = course_folder.load()
    assert not course.problems
    assert list(course.exercises) == ["m9/a", "m9/b"]
    exercise = course.exercises["m9/a"]
    assert [function.signature for function in exercise.functions] == ["double(x)"]
    assert "Une question" in exercise.hints[0]
    assert course.kits["m9"] == {"m9.py": "def configurer():\n    return {}\n"}


BROKEN = {
    "TOML that does not parse": ("exercise.toml", 'title = "Doubler"\nsummary = \n', 2, "TOML mal formé"),
    "TOML cut short": ("exercise.toml", 'title = "Doubler', 1, "TOML mal formé"),
    "unknown field": ("exercise.toml", EXERCISE.replace("order", "ordre = 3\norder"), 3, "ordre"),
    "wrong type": ("exercise.toml", EXERCISE.replace("order = 10", 'order = "dix"'), 3, "nombre entier"),
    "true is no number": ("exercise.toml", EXERCISE.replace("order = 10", "order = true"), 3, "nombre entier"),
    "missing field": ("exercise.toml", EXERCISE.replace("order = 10\n", ""), 1, "champ manquant : « order »"),
    "field of the second function": (
        "exercise.toml",
        EXERCISE + '\n[[functions]]\nname = "deux"\nsignature = 3\n',
        11,
        "signature",
    ),
    "field missing in the second function": (
        "exercise.toml",
        EXERCISE + '\n[[functions]]\nname = "deux"\n',
        9,
        "signature",
    ),
    "limit out of bounds": ("exercise.toml", EXERCISE + "\n[limits]\nmemory_bytes = 1000\n", 10, "memory_bytes"),
    "function that the grader does not know": (
        "exercise.toml",
        EXERCISE.replace('name = "double"', 'name = "doubler"'),
        None,
        "doubl",
    ),
    "bad TeX": ("enonce.md", "Texte.\n\nPuis $\\frac{1}{$ ici.\n", 3, "formule refusée"),
    "bad TeX inside a display": ("enonce.md", "Texte.\n\n$$\nx = 1 \\\\\ny = \\inconnu\n$$\n", 5, "formule refusée"),
    "unknown box": ("enonce.md", "Texte.\n\n::: sottise\nx\n:::\n", 3, "encadré inconnu"),
    "heading of level 1": ("enonce.md", "# Titre\n", 1, "niveau 1"),
    "image": ("enonce.md", "a\n\n![x](https://example.org/x.png)\n", 3, "images"),
    "not UTF-8": ("enonce.md", b"a\nb\xe9\n", 2, "UTF-8"),
    "two hints": ("indices.md", "## Indice 1\n\nx\n\n## Indice 2\n\ny\n", 5, "trois parties"),
    "hints out of order": ("indices.md", HINTS.replace("Indice 2", "Indice 4"), 9, "trois parties"),
    "empty hint": ("indices.md", HINTS.replace("La formule.", ""), 5, "indice vide"),
    "bad TeX in a hint": ("indices.md", HINTS.replace("La formule.", "$\\frac{$"), 7, "formule refusée"),
    "starter that does not compile": ("starter.py", "x = 1\ndef f(:\n", 2, "ne se compile pas"),
}


@pytest.mark.parametrize(("name", "content", "line", "message"), BROKEN.values(), ids=BROKEN.keys())
def test_a_malformed_file_is_reported_with_its_place(
    course_folder: CourseFolder, name: str, content: str | bytes, line: int | None, message: str
) -> None:
    path = course_folder.exercise("a") / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    course = course_folder.load()
    (problem,) = course.problems
    assert (problem.path, problem.line) == (path, line)
    assert message in problem.message
    assert list(course.exercises) == ["m9/b"]


@pytest.mark.parametrize("name", ["exercise.toml", "enonce.md", "indices.md", "starter.py"])
def test_a_missing_file_is_reported(course_folder: CourseFolder, name: str) -> None:
    path = course_folder.exercise("a") / name
    path.unlink()
    course = course_folder.load()
    (problem,) = course.problems
    assert (problem.path, problem.message) == (path, "fichier manquant")
    assert list(course.exercises) == ["m9/b"]


def test_a_solution_that_does_not_compile_is_reported(course_folder: CourseFolder) -> None:
    place = course_folder.root / "graders/m9/a"
    broken = definition(place, "def double(x):\n  return (\n")
    found = Discovery({**course_folder.graders("b").definitions, "m9/a": broken}, ())
    (problem,) = course_folder.load(found).problems
    assert problem.path == place / "solution.py"
    assert problem.line == 2


def test_a_grader_that_fails_to_import_is_reported_with_its_line(course_folder: CourseFolder) -> None:
    place = course_folder.root / "graders/m9/a/grader.py"
    found = Discovery(course_folder.graders("b").definitions, (GraderProblem(place, 7, "NameError: oubli"),))
    course = course_folder.load(found)
    assert (course.problems[0].path, course.problems[0].line) == (place, 7)
    assert any(one.path == course_folder.exercise("a") / "exercise.toml" for one in course.problems)
    assert list(course.exercises) == ["m9/b"]


def test_a_misconception_of_a_function_that_is_not_asked_for_is_reported_with_its_line(
    course_folder: CourseFolder,
) -> None:
    folder = course_folder.root / "graders/m9/a"
    lost = Misconception("perdue", ("triple",), "T", "E", "Q", "", line=12)
    found = course_folder.graders("a", "b")
    found.definitions["m9/a"] = replace(definition(folder), misconceptions=(lost,))
    course = course_folder.load(found)
    assert [(one.path, one.line) for one in course.problems] == [(folder / "misconceptions.toml", 12)]
    assert "triple" in course.problems[0].message
    assert list(course.exercises) == ["m9/b"]


def test_a_grader_without_exercise_is_reported(course_folder: CourseFolder) -> None:
    (problem,) = course_folder.load(course_folder.graders("a", "b", "perdu")).problems
    assert "m9/perdu" in problem.message


def test_a_malformed_module_leaves_the_others(course_folder: CourseFolder) -> None:
    path = course_folder.write("curriculum/m8/module.toml", "title = 3\n")
    course = course_folder.load()
    assert [(one.path, one.line) for one in course.problems] == [(path, 1)]
    assert list(course.modules) == ["m9"]


def test_names_that_would_clash_with_other_addresses_are_refused(course_folder: CourseFolder) -> None:
    course_folder.write("curriculum/connexion/module.toml", "")
    assert "nom de module" in course_folder.load().problems[0].message


def test_without_rendering_a_statement_is_read_when_it_is_asked_for(course_folder: CourseFolder) -> None:
    (course_folder.exercise("a") / "enonce.md").write_text("$\\frac{$")
    assert not course_folder.load(render=False).problems
