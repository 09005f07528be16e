"""The versions of the real exercises: each file that decides a verdict is in its exercise's version, and no other."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pytest

from graders.core.contract.verdict import Outcome
from server.base.files import ROOT
from server.course.closure import ImportGraph
from server.course.models import Exercise
from server.course.schemas import ExerciseFile
from server.course.toml_file import read_toml
from server.course.version import compute_exercise_version, iterate_grading_files
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox
from tests.support.quick import the_course
from tests.support.shipped import exercises_of_kind


@pytest.mark.parametrize("slug", ["predire2d", "calcul_odometrie"])
def test_each_file_that_grades_a_real_exercise_changes_its_version(tmp_path: Path, slug: str) -> None:
    for name in ("graders", "reference", "curriculum/l20/exercices", "curriculum/l20/kit"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    folder = tmp_path / "curriculum" / "l20" / "exercices" / slug
    card = read_toml(folder / "exercise.toml", ExerciseFile)
    exercise = the_course().exercises[f"l20/{slug}"]
    imports = ImportGraph(tmp_path)  # what is written below changes no import
    before = compute_exercise_version(imports, [tmp_path], folder, card, exercise.grader, exercise.kit)
    assert before == exercise.version, "a place on the disk is no part of it"
    grading = {
        path for _, path in iterate_grading_files(imports, [tmp_path], folder, card, exercise.grader, exercise.kit)
    }
    everything = {path for name in ("graders", "reference") for path in (tmp_path / name).rglob("*") if path.is_file()}
    assert len(grading) > 15
    for path in sorted(grading):
        kept = path.read_bytes()
        path.write_bytes(kept + b"\n#\n")
        assert compute_exercise_version(imports, [tmp_path], folder, card, exercise.grader, exercise.kit) != before, (
            path
        )
        path.write_bytes(kept)
    assert everything - grading
    for path in everything - grading:
        path.write_bytes(path.read_bytes() + b"\n#\n")
    assert compute_exercise_version(imports, [tmp_path], folder, card, exercise.grader, exercise.kit) == before


@cache
def imports_here() -> ImportGraph:
    return ImportGraph(ROOT)


def closure_of(exercise: Exercise) -> set[str]:
    described = imports_here().imported_files(f"graders.{exercise.module}.{exercise.slug}.grader")
    return {*described, *imports_here().imported_files(type(exercise.grader).__module__)}


def ours(modules: Iterable[str]) -> set[str]:
    """But for what says where courses stand: no verdict depends on it."""
    return {name for name in modules if name.split(".")[0] in {"graders", "reference"}} - {"graders.courses"}


#: One of each kind of exercise: the others are looked at with the slow tests.
SAMPLED = {"poses", "slam_graphe", "calcul_odometrie", "demo_1", "verification"}
EXERCISES = pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name.split("/")[1] in SAMPLED else pytest.mark.slow)
        for name in (*exercises_of_kind("code"), *exercises_of_kind("answers"))
    ],
)


@cache
def imported_with(*needed: str) -> set[str]:
    """The modules of ours that a new interpreter has once it has imported these."""
    code = f"import sys, json, {', '.join(needed)}; print(json.dumps([*sys.modules]))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return ours(json.loads(done.stdout))


@EXERCISES
def test_what_a_grader_really_imports_is_in_its_closure(name: str) -> None:
    """Statically found, it would silently miss a module whose name is computed."""
    exercise = the_course().exercises[name]
    modules = {f"graders.{exercise.module}.{exercise.slug}.grader", type(exercise.grader).__module__}
    needed = sorted(one for one in modules if Path(ROOT, *one.split(".")).with_suffix(".py").is_file())
    imported = imported_with(*needed)
    assert imported >= set(needed)
    assert imported <= closure_of(exercise)


@EXERCISES
def test_what_runs_to_grade_a_submission_is_in_the_closure(name: str, course_sandbox: Sandbox) -> None:
    """Also what is imported only then, for a right submission and for a mistake that has a name."""
    exercise = the_course().exercises[name]
    assert all(one.grader for one in the_course().exercises.values())  # the others are imported already
    known = list(exercise.grader.known_submissions())
    submissions = [known[0], next(one for one in known if one.diagnosis)] if exercise.kind == "code" else known[:4]
    grader, before, running = SandboxGrader(the_course(), course_sandbox), set(sys.modules), set()
    for submission in submissions:
        sys.setprofile(lambda frame, _event, _value: running.add(frame.f_globals.get("__name__", "")))
        try:
            outcome = grader.grade(exercise.id, submission.source_for_seed(3), 3).verdict.outcome
        finally:
            sys.setprofile(None)
        assert outcome is not Outcome.INTERNAL_ERROR
    assert ours(running) >= {"graders.core.contract.verdict"}
    assert ours(running | (set(sys.modules) - before)) <= closure_of(exercise)
