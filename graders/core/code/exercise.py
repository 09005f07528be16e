"""An exercise as its grader's folder describes it: checks, misconceptions, solution, specimens, figures."""

from __future__ import annotations

import importlib
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graders.core.code import grading
from graders.core.code.checks import Check
from graders.core.contract.findings import Grading
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings
from graders.core.contract.protocol import Known, Run
from graders.core.contract.verdict import MAX_POINTS

__all__ = ["ExerciseGrader", "MalformedExerciseError", "Misconception", "Specimen", "exercise"]

KitMaker = Callable[[np.random.Generator], KitSettings]


@dataclass(frozen=True)
class Misconception:
    """A named wrong implementation of `functions`; `source` is a whole submission that makes this mistake.

    Several may share an id: the same mistake leaves other outputs in code that, say, forgets to wrap angles besides.
    """

    id: str
    functions: tuple[str, ...]
    title: str
    explanation: str
    question: str
    source: str


@dataclass(frozen=True)
class Specimen:
    """A submission kept with the outcome that it must get."""

    outcome: Outcome
    path: Path


@dataclass(frozen=True)
class ExerciseGrader:
    """Everything that grades one exercise. `package` is its Python package, `folder` its place."""

    exercise: str
    package: str
    folder: Path
    functions: tuple[str, ...]
    checks: tuple[Check, ...]
    kit: KitMaker
    misconceptions: tuple[Misconception, ...]
    solution: str

    def specimens(self) -> Iterator[Specimen]:
        """The submissions under `specimens/<outcome>/`."""
        for path in sorted((self.folder / "specimens").glob("*/*.py")):
            yield Specimen(Outcome(path.parent.name), path)

    def grade(self, source: bytes, run: Run, *, seed: int, version: str) -> Grading:
        """The verdict of a file, whose program `run` starts."""
        return grading.grade(self, run(source), seed=seed, version=version)

    def rehearse(self) -> None:
        """Have imported and compiled what is so at first use."""
        grading.rehearse(self)

    def mistakes(self) -> frozenset[str]:
        """The ids of the misconceptions."""
        return frozenset(one.id for one in self.misconceptions)

    def known(self) -> Iterator[Known]:
        """The solution, the catalogued mistakes, the specimens."""
        yield Known("référence", _always(self.solution.encode()), Outcome.OK)
        for one in self.misconceptions:
            yield Known(f"erreur {one.id}", _always(one.source.encode()), diagnosis=one.id)
        for specimen in self.specimens():
            subject = f"spécimen {specimen.outcome.value}/{specimen.path.name}"
            yield Known(subject, _always(specimen.path.read_bytes()), specimen.outcome)

    def draw(self, data: dict[str, Any], *, theme: str = "light", extension: str = "svg") -> bytes:
        """Draw the figure whose data a verdict left, as a "svg" or "png" file. Slow: it loads matplotlib."""
        from graders.plotting import drawing, to_bytes

        module = importlib.import_module(f"{self.package}.figures")
        with drawing(theme) as figure:
            module.FIGURES[data["kind"]](figure, data)
            return to_bytes(figure, extension)


def _always(source: bytes) -> Callable[[int], bytes]:
    return lambda _seed: source


def exercise(
    package: str, file: str, slug: str, *, functions: Sequence[str], checks: Sequence[Check], kit: KitMaker
) -> ExerciseGrader:
    """Describe an exercise from its grader's module: `exercise(__package__, __file__, "l20/poses", ...)`.

    Raises MalformedExerciseError when the folder does not hold together.
    """
    folder = Path(file).parent
    total = sum(check.points for check in checks)
    if abs(total - MAX_POINTS) > 1e-9:
        raise MalformedExerciseError(Path(file), f"the checks sum to {total} points, not {MAX_POINTS}")
    if len({check.id for check in checks}) != len(checks):
        raise MalformedExerciseError(Path(file), "two checks have the same id")
    solution = _read(folder / "solution.py")
    misconceptions = tuple(_misconceptions(folder, solution, set(functions)))
    return ExerciseGrader(slug, package, folder, tuple(functions), tuple(checks), kit, misconceptions, solution)


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise MalformedExerciseError(path, f"cannot be read: {error.strerror}") from error


def _misconceptions(folder: Path, solution: str, functions: set[str]) -> Iterator[Misconception]:
    path = folder / "misconceptions.toml"
    try:
        entries = tomllib.loads(_read(path))["misconception"]
    except (tomllib.TOMLDecodeError, KeyError) as error:
        raise MalformedExerciseError(path, f"not a list of misconceptions: {error}") from error
    for entry in entries:
        yield from _misconception(folder, path, entry, solution, functions)


def _misconception(
    folder: Path, path: Path, entry: dict[str, Any], solution: str, functions: set[str]
) -> Iterator[Misconception]:
    missing = {"id", "functions", "title", "explanation", "question"} - entry.keys()
    if missing:
        raise MalformedExerciseError(path, f"misconception {entry.get('id', '?')} lacks {', '.join(sorted(missing))}")
    unknown = set(entry["functions"]) - functions
    if unknown:
        raise MalformedExerciseError(path, f"{entry['id']} speaks of unknown functions: {sorted(unknown)}")
    home = folder / "misconceptions"
    for file in (home / f"{entry['id']}.py", *sorted(home.glob(f"{entry['id']}__*.py"))):
        yield Misconception(
            id=entry["id"],
            functions=tuple(entry["functions"]),
            title=entry["title"],
            explanation=entry["explanation"],
            question=entry["question"],
            source=f"{solution}\n\n{_read(file)}",
        )
