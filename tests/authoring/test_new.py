"""Skeletons: each does what it says as it was written, and names that do not do are told before anything is written."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from graders.core.contract.kits import SCENARIOS
from graders.core.contract.local import LOCAL
from server.authoring import new
from server.base.version import VERSION
from server.cli.authors import KINDS
from server.cli.check import list_cases
from server.course import Course
from server.grading.sandbox_grader import SandboxPrograms
from server.replays.service import load_replay
from server.sandbox import Sandbox
from tests.authoring.conftest import WRITTEN


def test_there_is_a_skeleton_of_each_kind_that_the_command_line_names() -> None:
    skeletons = {folder.name for folder in new.SKELETONS.iterdir()} - {new.COURSE}
    assert skeletons == set(KINDS) == {kind for kind, _ in WRITTEN}


def test_all_that_is_written_holds_together(course: Course) -> None:
    outside = [problem for problem in course.problems if "n’a pas d’exercice" not in problem.message]
    assert outside == []
    module = course.modules["l21"]
    assert [lesson.slug for lesson in module.lessons] == ["gain", "premiers-pas"]
    assert [exercise.slug for exercise in module.exercises] == ["gain", "mots", "verification", "calcul", "demo"]


def test_what_is_written_says_which_version_wrote_it(place: Path) -> None:
    files = [path for path in place.rglob("*") if path.is_file()]
    stamped = {path for path in files if f"version {VERSION}.".encode() in path.read_bytes()}
    settings = {*place.rglob("*.toml"), *place.glob("curriculum/*/rejeux/*.py"), *place.glob("curriculum/*/lire/*.md")}
    assert settings <= stamped
    assert len(settings) > 10
    assert not [path for path in stamped if path.name in ("starter.py", "solution.py", "enonce.md")]


def test_what_is_known_of_each_exercise_gets_what_it_must(course: Course, sandbox: Sandbox) -> None:
    tried = 0
    for exercise in course.exercises.values():
        for case in list_cases(exercise):
            programs = SandboxPrograms(sandbox, exercise.policy) if exercise.kit == SCENARIOS else LOCAL
            judgement = exercise.grader.grade(case.write(3), programs, seed=3, version=exercise.version)
            assert case.judge(judgement) == "", (exercise.id, case.subject)
            tried += 1
    assert tried > 15


def test_a_wrong_program_has_its_name_and_its_figure(course: Course) -> None:
    from graders.plotting import counterexample  # loads matplotlib

    exercise = course.exercises["l21/gain"]
    wrong = b"def gain(a, b, t):\n    return b + t * (a - b)\n"
    judgement = exercise.grader.grade(wrong, LOCAL, seed=3, version=exercise.version)
    assert judgement.verdict.diagnosis
    assert judgement.verdict.diagnosis.title == "Le départ et l'arrivée sont échangés"
    (data, *_) = judgement.figures.values()
    assert b"<svg" in counterexample("l21/gain", data)


def test_a_replay_plays(place: Path, course: Course) -> None:
    script = load_replay(place / "curriculum" / "l21", "derive-lente")
    assert len(script.run(script.read([("pas", "4")]))["frames"]) == 5


def test_a_course_is_a_package_that_names_itself(place: Path) -> None:
    project = tomllib.loads((place / "pyproject.toml").read_text(encoding="utf-8"))
    ((name, package),) = project["project"]["entry-points"]["balise.courses"].items()
    sources = project["tool"]["hatch"]["build"]["targets"]["wheel"]["sources"]
    assert {path.split("/")[0] for path in sources.values()} == {package}
    assert name == project["project"]["name"]


@pytest.mark.parametrize(
    ("kind", "name", "said"),
    [
        ("module", "Kalman", "l19"),
        ("module", "l20", "curriculum/l20"),
        ("exercise", "l18/gain", "balise new module l18"),
        ("exercise", "gain", "l19/gain"),
        ("exercise", "l21/Gain", "minuscules"),
        ("exercise", "l21/2gains", "lettre"),
        ("exercise", "l21/a/gain", "l21/gain"),
        ("exercise", "l21/gain", "exercices/gain"),
        ("page", "l21/memos/gain", "fiches"),
        ("page", "l21/cours/gain", "fiches/gain.md"),
        ("page", "l21/Le-gain", "tirets"),
        ("exercise", "../gain", "module"),
        ("page", "l21/../gain", "dossiers"),
    ],
)
def test_a_name_that_does_not_do_is_told_and_nothing_is_written(place: Path, kind: str, name: str, said: str) -> None:
    before = sorted(place.rglob("*"))
    with pytest.raises(new.SkeletonRefused, match=said):
        new.write_skeleton(kind, name, place)
    assert sorted(place.rglob("*")) == before
