"""Courses outside this repository: what is taken in, and names that two of them have."""

from __future__ import annotations

from pathlib import Path

import pytest

from graders.courses import OWN, VARIABLE, Courses, found


def course(root: Path, *files: str) -> Path:
    for name in ("curriculum/m9/module.toml", *files):
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    return root


def told(courses: Courses) -> list[str]:
    return [f"{problem.path}: {problem.message}" for problem in courses.problems]


def test_a_course_is_taken_in_once(tmp_path: Path) -> None:
    courses = Courses()
    courses.add(course(tmp_path, "graders/m9/gain/grader.py", "reference/kalman.py", "graders/README.md"))
    courses.add(tmp_path / "curriculum" / "..")
    assert (courses.places, courses.problems) == ([OWN, tmp_path], [])


@pytest.mark.parametrize(
    ("file", "taken"),
    [
        ("curriculum/l20/module.toml", OWN / "curriculum" / "l20"),
        ("graders/core/x.py", OWN / "graders" / "core"),
        ("graders/plotting/x.py", OWN / "graders" / "plotting.py"),
        ("reference/se2.py", OWN / "reference" / "se2"),
    ],
)
def test_a_name_that_is_taken_is_told_with_both_places(tmp_path: Path, file: str, taken: Path) -> None:
    courses = Courses()
    courses.add(course(tmp_path, file))
    assert courses.places == [OWN], "left out whole: half a course would be worse"
    (message,) = told(courses)
    assert str(taken.with_suffix("")) in message
    assert message.startswith(str(tmp_path / Path(file).parts[0] / Path(file).parts[1]))


def test_two_courses_outside_may_clash_too(tmp_path: Path) -> None:
    courses = Courses()
    first, second = course(tmp_path / "a"), course(tmp_path / "b")
    courses.add(first)
    courses.add(second)
    assert courses.places == [OWN, first]
    assert str(first / "curriculum" / "m9") in told(courses)[0]


def test_what_is_no_course_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "vide").mkdir()
    shadow = course(tmp_path / "c", "graders/__init__.py")
    monkeypatch.setenv(VARIABLE, f"{tmp_path / 'nulle-part'}:{tmp_path / 'vide'}:{shadow}:")
    courses = found()
    assert courses.places == [OWN]
    nowhere, empty, shadowing = told(courses)
    assert "n’existe pas" in nowhere
    assert "curriculum" in empty
    assert str(shadow / "graders" / "__init__.py") in shadowing
