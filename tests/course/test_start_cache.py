"""The start cache of the course: nothing that has changed since, and nothing that was not sound, is taken from it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from graders.discovery import Discovery
from server.course import Course
from server.course.closure import ImportGraph
from server.course.library import ModuleTexts
from server.course.service import load_course
from server.course.start_cache import StartCache
from tests.support.quick import the_course
from tests.support.small_course import CourseFolder


@pytest.fixture
def looks(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The modules of which the texts were looked at."""
    seen: list[Path] = []
    check = ModuleTexts.find_text_problems

    def counted(library: ModuleTexts, *, formulas: bool) -> Any:
        seen.append(library.folder)
        return check(library, formulas=formulas)

    monkeypatch.setattr(ModuleTexts, "find_text_problems", counted)
    return seen


def test_texts_that_were_sound_are_looked_at_again_once_anything_has_changed(
    course_folder: CourseFolder, tmp_path: Path, looks: list[Path]
) -> None:
    kept = tmp_path / "course.json"

    def start() -> int:
        """How many modules were looked at."""
        before = len(looks)
        loaded = load_small(course_folder, StartCache(kept))
        assert (len(loaded.exercises), len(loaded.problems)) in {(2, 0), (1, 1)}, "what does not hold is not served"
        return len(looks) - before

    assert [start(), start()] == [1, 0]
    statement = course_folder.exercise("a") / "enonce.md"
    statement.write_text("## Énoncé\n\nVoyez [une page](page:nulle-part).\n", encoding="utf-8")
    assert [start(), start()] == [1, 1], "what is not sound is told at each start"
    assert load_small(course_folder, StartCache(kept)).problems
    statement.write_text("## Énoncé\n\nTriplez $x$.\n", encoding="utf-8")
    assert [start(), start()] == [1, 0]
    course_folder.write("graders/core/reader.py", "x = 1\n")
    assert [start(), start()] == [1, 0]
    kept.write_text('{"sound": 3')
    assert [start(), start()] == [1, 0]


def test_what_was_sound_is_graded_by_graders_that_are_loaded_when_they_are_needed(
    course_folder: CourseFolder, tmp_path: Path
) -> None:
    first, second = (load_small(course_folder, StartCache(tmp_path / "course.json")) for _ in range(2))
    for name, known in first.exercises.items():
        again = second.exercises[name]
        assert (again.version, again.kit, again.kind) == (known.version, known.kit, known.kind)
        assert (again.starter, again.solution) == (known.starter, known.solution)
        assert "grader" not in vars(again)
        assert again.grader.exercise == known.grader.exercise == name
        assert again.grader is again.grader


def test_a_worker_takes_what_the_service_has_found_and_keeps_nothing(
    course_folder: CourseFolder, tmp_path: Path
) -> None:
    """It does not look at the texts, nor for graders as it starts; of other files, nothing is known."""
    kept = tmp_path / "course.json"
    served = load_small(course_folder, StartCache(kept))
    remembered = kept.read_text()
    nowhere = Discovery({}, ())

    def taken() -> Course:
        return course_folder.load(nowhere, render=False, memory=StartCache(kept))

    assert taken().problems == ()
    assert {name: one.version for name, one in taken().exercises.items()} == {
        name: one.version for name, one in served.exercises.items()
    }
    course_folder.write("graders/core/reader.py", "x = 1\n")
    assert (len(taken().exercises), len(taken().problems)) == (0, 2)
    assert kept.read_text() == remembered


def test_what_an_older_version_has_remembered_is_no_damage(
    course_folder: CourseFolder, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    kept = tmp_path / "course.json"
    known = load_small(course_folder, StartCache(kept))
    remembered = json.loads(kept.read_text())
    del remembered["found"]
    kept.write_text(json.dumps(remembered))
    assert load_small(course_folder, StartCache(kept)).exercises.keys() == known.exercises.keys()
    assert "found" in json.loads(kept.read_text())
    assert not caplog.records


@pytest.mark.parametrize("exercise", ["l20/tp_slam", "l20/calcul_kabsch"])
def test_an_exercise_that_is_read_alone_is_that_of_the_course(exercise: str) -> None:
    whole, alone = the_course(), load_course(render=False, only=exercise)
    assert alone.exercises.keys() == {exercise, *(one.id for one in whole.importable_exercises(exercise))}
    assert {name: one.version for name, one in alone.exercises.items()} == {
        name: whole.exercises[name].version for name in alone.exercises
    }
    assert not alone.problems
    module, _, _ = exercise.partition("/")
    assert module in alone.kits
    assert alone.kits == {name: whole.kits[name] for name in alone.kits}


def test_what_is_no_exercise_is_read_as_nothing() -> None:
    assert not any(
        load_course(render=False, only=name).exercises for name in ("l20/inconnu", "l99/poses", "l20", "../../etc")
    )


def load_small(folder: CourseFolder, memory: StartCache) -> Any:
    return load_course(
        folder.curriculum, code=folder.root, discovery=folder.graders("a", "b"), render=False, check=True, memory=memory
    )


def test_imports_are_remembered_by_what_a_file_holds(tmp_path: Path) -> None:
    for name, text in (("near", "import graders.far\n"), ("far", ""), ("other", "")):
        (tmp_path / "graders").mkdir(exist_ok=True)
        (tmp_path / "graders" / f"{name}.py").write_text(text)
    kept = tmp_path / "course.json"

    def closure() -> set[str]:
        memory = StartCache(kept)
        found = set(ImportGraph(tmp_path, memory=memory).imported_files("graders.near"))
        memory.save_used_entries("", {})
        return found

    assert closure() == closure() == {"graders.near", "graders.far"}
    (tmp_path / "graders" / "near.py").write_text("from graders import other\n")
    assert closure() == {"graders.near", "graders.other"}
