"""Discovery of the graders: every package `graders.<module>.<slug>` that holds a `grader` module with a GRADER."""

from __future__ import annotations

import importlib
import traceback
from dataclasses import dataclass
from pathlib import Path

from graders.core.answers import AnswersDefinition
from graders.core.code.exercise import ExerciseGrader, MalformedExerciseError

ROOT = Path(__file__).resolve().parent


@dataclass(frozen=True)
class Problem:
    """A malformed exercise: the others still serve."""

    path: Path
    line: int
    message: str


#: An exercise of code grades as it is; one that is answered without code is bound to its questions first.
Found = ExerciseGrader | AnswersDefinition


@dataclass(frozen=True)
class Discovery:
    """The graders found, by exercise name ("l20/poses"), and what was wrong with the rest."""

    graders: dict[str, Found]
    problems: tuple[Problem, ...]


def discover() -> Discovery:
    """Import every grader below this package."""
    graders: dict[str, Found] = {}
    problems: list[Problem] = []
    for path in sorted(ROOT.glob("*/*/grader.py")):
        try:
            grader = _load(path)
        except MalformedExerciseError as error:
            problems.append(Problem(error.path, error.line, error.message))
        except Exception as error:  # any mistake of an author's module is reported with its place
            problems.append(_problem(path, error))
        else:
            graders[grader.exercise] = grader
    return Discovery(graders, tuple(problems))


def _load(path: Path) -> Found:
    name = ".".join(path.relative_to(ROOT.parent).with_suffix("").parts)
    grader = getattr(importlib.import_module(name), "GRADER", None)
    if not isinstance(grader, Found):
        raise MalformedExerciseError(path, "defines no GRADER")
    slug = "/".join(path.parent.relative_to(ROOT).parts)
    if grader.exercise != slug:
        raise MalformedExerciseError(path, f"is named {grader.exercise!r} but stands in {slug!r}")
    return grader


def _problem(path: Path, error: Exception) -> Problem:
    if isinstance(error, SyntaxError):
        return Problem(Path(error.filename or path), error.lineno or 1, f"syntax error: {error.msg}")
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if str(ROOT) in frame.filename]
    own = [frame for frame in frames if Path(frame.filename).parent == path.parent]
    message = f"{type(error).__name__}: {error}"
    return Problem(path, 1, message) if not own else Problem(Path(own[-1].filename), own[-1].lineno or 1, message)
