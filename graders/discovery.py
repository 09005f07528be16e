"""Discovery of the graders: every package `graders.<module>.<slug>` that holds a `grader` module with a DEFINITION."""

from __future__ import annotations

import importlib
import traceback
from dataclasses import dataclass
from pathlib import Path

from graders.core.answers import NumericDefinition
from graders.core.code.exercise import CodeDefinition
from graders.core.contract.definition import Definition
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


def discover() -> Discovery:
    """Import every grader below this package."""
    definitions: dict[str, Definition] = {}
    problems: list[Problem] = []
    for path in sorted(ROOT.glob("*/*/grader.py")):
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
