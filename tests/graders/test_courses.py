"""Courses outside this repository: what is taken in, and names that two of them have."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from graders.courses import ENTRY_POINT_GROUP, ENVIRONMENT_VARIABLE, REPOSITORY, Courses, find_courses


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
    assert (courses.folders, courses.problems) == ([REPOSITORY, tmp_path], [])


@pytest.mark.parametrize(
    ("file", "taken"),
    [
        ("curriculum/l20/module.toml", REPOSITORY / "curriculum" / "l20"),
        ("graders/core/x.py", REPOSITORY / "graders" / "core"),
        ("graders/plotting/x.py", REPOSITORY / "graders" / "plotting.py"),
        ("reference/se2.py", REPOSITORY / "reference" / "se2"),
    ],
)
def test_a_name_that_is_taken_is_told_with_both_places(tmp_path: Path, file: str, taken: Path) -> None:
    courses = Courses()
    courses.add(course(tmp_path, file))
    assert courses.folders == [REPOSITORY], "left out whole: half a course would be worse"
    (message,) = told(courses)
    assert str(taken.with_suffix("")) in message
    assert message.startswith(str(tmp_path / Path(file).parts[0] / Path(file).parts[1]))


def test_two_courses_outside_may_clash_too(tmp_path: Path) -> None:
    courses = Courses()
    first, second = course(tmp_path / "a"), course(tmp_path / "b")
    courses.add(first)
    courses.add(second)
    assert courses.folders == [REPOSITORY, first]
    assert str(first / "curriculum" / "m9") in told(courses)[0]


def test_so_may_what_only_their_own_files_import(tmp_path: Path) -> None:
    courses = Courses()
    first = course(tmp_path / "a", "reference/_common.py", "curriculum/_brouillons/a.md")
    (tmp_path / "b" / "curriculum" / "m8").mkdir(parents=True)
    courses.add(first)
    for name in ("reference/_common.py", "curriculum/_brouillons/a.md"):
        path = tmp_path / "b" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")
    courses.add(tmp_path / "b")
    assert courses.folders == [REPOSITORY, first], "else one course would run the other’s numerics"
    assert [one.path for one in courses.problems] == [tmp_path / "b" / "reference" / "_common.py"], "no code, no clash"


def test_a_folder_that_cannot_be_read_keeps_nobody_from_serving(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loop = tmp_path / "boucle"
    loop.symlink_to(loop)
    good = course(tmp_path / "bon")

    def unreadable(room: Path) -> Iterator[Path]:
        if room.is_relative_to(tmp_path / "ferme"):
            raise PermissionError(13, "Permission denied", str(room))
        yield from listed(room)

    listed = Path.iterdir
    monkeypatch.setattr(Path, "iterdir", unreadable)
    closed = course(tmp_path / "ferme")
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, f"{loop}:~personne-ici/cours:{closed}:{good}")
    courses = find_courses()
    assert courses.folders == [REPOSITORY, good]
    assert len(courses.problems) == 3
    assert "ne se lit pas" in told(courses)[-1]


def test_a_package_that_fails_as_it_is_looked_for_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "casse_m9").mkdir()
    (tmp_path / "casse_m9" / "__init__.py").write_text("1 / 0")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(
        "importlib.metadata.entry_points", lambda **_: [EntryPoint("m9", "casse_m9.cours", ENTRY_POINT_GROUP)]
    )
    monkeypatch.delenv(ENVIRONMENT_VARIABLE, raising=False)
    (problem,) = find_courses().problems
    assert "casse_m9.cours" in problem.message


def test_what_is_no_course_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "vide").mkdir()
    shadow = course(tmp_path / "c", "graders/__init__.py")
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, f"{tmp_path / 'nulle-part'}:{tmp_path / 'vide'}:{shadow}:")
    courses = find_courses()
    assert courses.folders == [REPOSITORY]
    nowhere, empty, shadowing = told(courses)
    assert "n’existe pas" in nowhere
    assert "curriculum" in empty
    assert str(shadow / "graders" / "__init__.py") in shadowing
