"""Discovery of the graders: every package `graders.<module>.<slug>` that holds a `grader` module with a DEFINITION."""

from __future__ import annotations

import importlib
import traceback
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from graders.core.answers import NumericDefinition
from graders.core.code.exercise import CodeDefinition
from graders.core.contract.definition import MODULE_FILE, Definition
from graders.core.contract.malformed import MalformedExerciseError

ROOT = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Problem:
    """A malformed exercise: the others still serve."""

    path: Path
    line: int
    message: str


@dataclass(frozen=True)
class Discovery:
    """The definitions found, by exercise name ("l20/poses"), and what was wrong with the rest."""

    definitions: dict[str, Definition]
    problems: tuple[Problem, ...]


def find(exercise: str) -> Definition:
    """The definition of one exercise ("l20/poses"), which is known to be sound. Raises what its module raises."""
    return _load(ROOT / exercise / MODULE_FILE)


def discover(exercises: Collection[str] | None = None) -> Discovery:
    """Import every grader below this package, or those of some exercises."""
    definitions: dict[str, Definition] = {}
    problems: list[Problem] = []
    for path in sorted(ROOT.glob(f"*/*/{MODULE_FILE}")):
        if exercises is not None and f"{path.parts[-3]}/{path.parts[-2]}" not in exercises:
            continue
        try:
            definition = _load(path)
        except MalformedExerciseError as error:
            problems.append(Problem(error.path, error.line, error.message))
        except Exception as error:  # any mistake of an author's module is reported with its place
            problems.append(_problem(path, error))
        else:
            definitions[definition.exercise] = definition
    return Discovery(definitions, tuple(problems))


def _load(path: Path) -> Definition:
    name = ".".join(path.relative_to(ROOT.parent).with_suffix("").parts)
    definition = getattr(importlib.import_module(name), "DEFINITION", None)
    if not isinstance(definition, CodeDefinition | NumericDefinition):
        raise MalformedExerciseError(path, "defines no DEFINITION")
    if definition.folder.resolve() != path.parent:
        raise MalformedExerciseError(path, f"defines the exercise of another folder, {definition.folder}")
    return definition


def _problem(path: Path, error: Exception) -> Problem:
    if isinstance(error, SyntaxError):
        return Problem(Path(error.filename or path), error.lineno or 1, f"syntax error: {error.msg}")
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if str(ROOT) in frame.filename]
    own = [frame for frame in frames if Path(frame.filename).parent == path.parent]
    message = f"{type(error).__name__}: {error}"
    return Problem(path, 1, message) if not own else Problem(Path(own[-1].filename), own[-1].lineno or 1, message)
