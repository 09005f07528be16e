"""The graders of code that are shipped: named by their folders, each loaded when it is first asked for."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graders.core.code.grading import CodeGrader

ROOT = Path(__file__).resolve().parents[2]


MODULES = tuple(sorted(file.parent.name for file in (ROOT / "curriculum").glob("*/module.toml")))


@cache
def exercises_of_kind(kind: str) -> tuple[str, ...]:
    """The ids of the exercises of a kind, "code" or "answers", read in their TOML files; no grader is imported."""
    files = sorted((ROOT / "curriculum").glob("*/exercices/*/exercise.toml"))
    return tuple(_id_of(file) for file in files if _card(file).get("kind", "code") == kind)


def _id_of(file: Path) -> str:
    return f"{file.parents[2].name}/{file.parent.name}"


@cache
def _card(file: Path) -> dict[str, object]:
    return tomllib.loads(file.read_text(encoding="utf-8"))


@cache
def shipped_grader(exercise: str) -> CodeGrader:
    """The grader of an exercise of code, steady (see `tests.support.reenactments`); the course is not loaded."""
    from graders.core.code.exercise import CodeDefinition
    from graders.discovery import load_definition
    from tests.support.reenactments import steady

    module, slug = exercise.split("/")
    definition = load_definition(exercise)
    assert isinstance(definition, CodeDefinition)
    functions = _card(ROOT / "curriculum" / module / "exercices" / slug / "exercise.toml")["functions"]
    assert isinstance(functions, list)
    return steady(definition.bind([function["name"] for function in functions]))


class _Shipped(Mapping[str, "CodeGrader"]):
    def __iter__(self) -> Iterator[str]:
        return iter(exercises_of_kind("code"))

    def __len__(self) -> int:
        return len(exercises_of_kind("code"))

    def __getitem__(self, exercise: str) -> CodeGrader:
        return shipped_grader(exercise)


#: By exercise ("l20/poses").
CODE: Mapping[str, CodeGrader] = _Shipped()
