"""What the folder of an exercise of code holds: the solution, the named misconceptions, the specimens."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.outcomes import Outcome

MISCONCEPTIONS = "misconceptions.toml"
FIELDS = {"id", "functions", "title", "explanation", "question"}


@dataclass(frozen=True)
class Misconception:
    """A named wrong implementation of `functions`; `source` is a whole submission that makes this mistake.

    Several may share an id: the same mistake leaves other outputs in code that, say, forgets to wrap angles besides.
    `line` is its place in the catalogue.
    """

    id: str
    functions: tuple[str, ...]
    title: str
    explanation: str
    question: str
    source: str
    line: int = 1


@dataclass(frozen=True)
class Specimen:
    """A submission kept with the outcome that it must get."""

    outcome: Outcome
    path: Path


def read_solution(folder: Path) -> str:
    """The reference solution. Raises MalformedExerciseError."""
    return _read(folder / "solution.py")


def read_misconceptions(folder: Path, solution: str) -> Iterator[Misconception]:
    """The catalogue, each misconception as the solution with a mistake. Raises MalformedExerciseError."""
    path = folder / MISCONCEPTIONS
    text = _read(path)
    try:
        entries = tomllib.loads(text)["misconception"]
    except (tomllib.TOMLDecodeError, KeyError) as error:
        raise MalformedExerciseError(path, f"not a list of misconceptions: {error}") from error
    headers = re.finditer(r"^[ \t]*\[\[[ \t]*misconception[ \t]*\]\]", text, re.MULTILINE)
    lines = (text[: header.start()].count("\n") + 1 for header in headers)
    for entry in entries:
        yield from _misconceptions(folder, entry, next(lines, 1), solution)


def _misconceptions(folder: Path, entry: dict[str, Any], line: int, solution: str) -> Iterator[Misconception]:
    missing = FIELDS - entry.keys()
    if missing:
        message = f"misconception {entry.get('id', '?')} lacks {', '.join(sorted(missing))}"
        raise MalformedExerciseError(folder / MISCONCEPTIONS, message, line)
    home = folder / "misconceptions"
    for file in (home / f"{entry['id']}.py", *sorted(home.glob(f"{entry['id']}__*.py"))):
        yield Misconception(
            id=entry["id"],
            functions=tuple(entry["functions"]),
            title=entry["title"],
            explanation=entry["explanation"],
            question=entry["question"],
            source=f"{solution}\n\n{_read(file)}",
            line=line,
        )


def same_functions(folder: Path, misconceptions: Sequence[Misconception], functions: Sequence[str]) -> None:
    """Misconceptions speak of the functions that are asked for. Raises MalformedExerciseError with their line."""
    for misconception in misconceptions:
        unknown = sorted(set(misconception.functions) - set(functions))
        if unknown:
            message = f"{misconception.id} speaks of unknown functions: {unknown}"
            raise MalformedExerciseError(folder / MISCONCEPTIONS, message, misconception.line)


def read_specimens(folder: Path) -> Iterator[Specimen]:
    """The submissions under `specimens/<outcome>/`. Raises MalformedExerciseError for a folder that names none."""
    for path in sorted((folder / "specimens").glob("*/*.py")):
        if path.parent.name not in set(Outcome):
            raise MalformedExerciseError(path, f"{path.parent.name} is no outcome")
        yield Specimen(Outcome(path.parent.name), path)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise MalformedExerciseError(path, f"cannot be read: {error.strerror}") from error
