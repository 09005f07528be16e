"""Discovery of the graders: every package `graders.<module>.<slug>` that holds a `grader` module with a DEFINITION."""

from __future__ import annotations

import importlib
import traceback
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from graders import courses
from graders.core.contract.definition import MODULE_FILE, Definition
from graders.core.contract.malformed import MalformedExerciseError
from graders.courses import CourseProblem


@dataclass(frozen=True)
class Discovery:
    """The definitions found, by exercise name ("l20/poses"), and what was wrong with the rest."""

    definitions: dict[str, Definition]
    problems: tuple[CourseProblem, ...]


def load_definition(exercise: str) -> Definition:
    """The definition of one exercise ("l20/poses"), which is known to be sound. Raises what its module raises."""
    candidates = ((room, room / exercise / MODULE_FILE) for room in courses.room_folders(courses.GRADERS))
    return _load(*next((room, path) for room, path in candidates if path.is_file()))


def discover(exercises: Collection[str] | None = None, rooms: Sequence[Path] | None = None) -> Discovery:
    """Import every grader of this repository and of the courses outside it, or those of some exercises, or of some
    rooms alone."""
    definitions: dict[str, Definition] = {}
    problems = [*courses.COURSES.problems]
    for room, path in _graders(courses.room_folders(courses.GRADERS) if rooms is None else rooms):
        if exercises is not None and f"{path.parts[-3]}/{path.parts[-2]}" not in exercises:
            continue
        try:
            definition = _load(room, path)
        except MalformedExerciseError as error:
            problems.append(CourseProblem(error.path, error.line, error.message))
        except Exception as error:  # any mistake of an author's module is reported with its place
            problems.append(_problem(room, path, error))
        else:
            definitions[definition.exercise] = definition
    return Discovery(definitions, tuple(problems))


def _graders(rooms: Sequence[Path]) -> Iterator[tuple[Path, Path]]:
    """The graders' modules, each with the room where it stands."""
    for room in rooms:
        yield from ((room, path) for path in sorted(room.glob(f"*/*/{MODULE_FILE}")))


def _load(room: Path, path: Path) -> Definition:
    name = ".".join(path.relative_to(room.parent).with_suffix("").parts)
    definition = getattr(importlib.import_module(name), "DEFINITION", None)
    if not isinstance(definition, Definition):
        raise MalformedExerciseError(
            path,
            "ce correcteur n’a pas de DEFINITION : écrivez « DEFINITION = code(__file__, checks=…) » ou « numeric(…) »",
        )
    if definition.folder.resolve() != path.parent:
        raise MalformedExerciseError(
            path, f"ce correcteur est celui d’un autre dossier, {definition.folder} : écrivez code(__file__, …)"
        )
    return definition


def _problem(room: Path, path: Path, error: Exception) -> CourseProblem:
    if isinstance(error, SyntaxError):
        return CourseProblem(
            Path(error.filename or path), error.lineno or 1, f"ce fichier Python ne se compile pas ({error.msg})"
        )
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if str(room) in frame.filename]
    own = [frame for frame in frames if Path(frame.filename).parent == path.parent]
    message = f"{type(error).__name__}: {error}"
    return (
        CourseProblem(path, 1, message)
        if not own
        else CourseProblem(Path(own[-1].filename), own[-1].lineno or 1, message)
    )
