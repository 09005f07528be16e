"""Grading on this machine, without server nor database."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from server.base.files import default_cache_dir
from server.cli import CommandError
from server.cli.sandboxes import Probing, require_safe_sandbox
from server.course import Course, Exercise, load_course
from server.course.start_cache import StartCache
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Sandbox

#: Cached imports of the files that decide a verdict, by content.
IMPORTS = "imports.json"


def load_unrendered_course() -> Course:
    return load_course(render=False)


def load_course_of_exercise(exercise_id: str) -> Course:
    """The course with this exercise alone and those that it reuses; all of it where there is no such exercise."""
    memory = StartCache(_start_cache_path())
    course = load_course(render=False, only=exercise_id, memory=memory)
    memory.save_used_entries("", {})
    return course if exercise_id in course.exercises else load_unrendered_course()


def _start_cache_path() -> Path | None:
    """Where this user may write, if there is such a place."""
    folder = default_cache_dir()
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError:
        return None
    return folder / IMPORTS if os.access(folder, os.W_OK) else None


def find_exercise(course: Course, exercise_id: str) -> Exercise:
    exercise = course.exercises.get(exercise_id)
    if exercise is None:
        raise CommandError(f"l’exercice « {exercise_id} » n’existe pas. {_list_exercise_names(course)}")
    return exercise


def _list_exercise_names(course: Course) -> str:
    broken = "".join(f"\n  {problem}" for problem in course.problems)
    return "Exercices : " + ", ".join(course.exercises) + "." + broken


@contextmanager
def local_grader(course: Course, probing: Probing | None) -> Iterator[SandboxGrader]:
    """A grader with its own sandbox; refuses where the walls do not stand. None: nothing is going to run in it."""
    if probing is not None:
        require_safe_sandbox(probing)
    with Sandbox(course.kits) as sandbox:
        yield SandboxGrader(course, sandbox)
