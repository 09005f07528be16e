"""Whether the animations of the course play as they are first shown: what `balise check` and the preview ask."""

import traceback
from collections.abc import Iterator
from pathlib import Path

from server.course import Course, Problem
from server.course.code import MANIPULATIONS
from server.replays.service import list_replay_names, load_replay, load_scene


def find_replay_faults(course: Course) -> Iterator[Problem]:
    """A problem for each that does not, where its own file went wrong."""
    for module in course.modules.values():
        for name in list_replay_names(module.folder):
            path = module.folder / "rejeux" / f"{name.replace('-', '_')}.py"
            try:
                script = load_replay(module.folder, name)
                script.run(script.read(()))
            except Exception as error:  # whatever an author's function raises is reported with its place
                yield _problem_of_error(path, f"l’animation « {name} »", error)
        for path in sorted((module.folder / MANIPULATIONS).glob("*/scene.py")):
            try:
                script = load_scene(path, path.parent.name)
                script.run(script.read(()))
            except Exception as error:
                yield _problem_of_error(path, f"la manipulation « {path.parent.name} »", error)


def _problem_of_error(path: Path, what: str, error: Exception) -> Problem:
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename) == path]
    return Problem(path, lines[-1] if lines else None, f"{what} ne se joue pas ({type(error).__name__}: {error})")
