"""What the catalogue holds: modules, exercises, and the problems found while reading them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from server.catalogue import markdown

if TYPE_CHECKING:
    from graders.core.exercise import ExerciseGrader


@dataclass(frozen=True)
class Problem:
    """A fault in the course's own files. `line` counts from 1; None when the fault is not in one line."""

    path: Path
    line: int | None
    message: str

    def __str__(self) -> str:
        place = str(self.path) if self.line is None else f"{self.path}:{self.line}"
        return f"{place}: {self.message}"


class CatalogueFault(Exception):
    """Raised inside the catalogue's loader only: carries the problem to report."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(str(problem))
        self.problem = problem


@dataclass(frozen=True)
class FunctionSpec:
    """A function (or class) that the student writes. `signature` is shown as it stands."""

    name: str
    signature: str
    returns: str
    doc: str


@dataclass(frozen=True, eq=False)
class Exercise:
    """One exercise, ready to serve. `id` is "module/slug"; `stars` counts the ★ of a challenge (0 to 3).

    `version` is the first 12 hexadecimal digits of a sha256 over everything that can change a verdict.
    `policy_overrides` replaces fields of `server.sandbox.Policy` by name.
    """

    module: str
    slug: str
    title: str
    summary: str
    order: int
    stars: int
    course: str
    functions: tuple[FunctionSpec, ...]
    starter: str
    solution: str
    statement: markdown.Source
    hint_sources: tuple[markdown.Source, markdown.Source, markdown.Source]
    grader: ExerciseGrader
    version: str
    policy_overrides: Mapping[str, Any] = field(default_factory=dict)

    @property
    def id(self) -> str:
        return f"{self.module}/{self.slug}"

    @cached_property
    def statement_html(self) -> str:
        """The statement as HTML. Raises `markdown.MarkupError` where a formula is wrong."""
        return markdown.render(self.statement)

    @cached_property
    def hints(self) -> tuple[str, str, str]:
        """The three hints as HTML: a question, a pointer to the formula, a commented sketch."""
        first, second, third = self.hint_sources
        return markdown.render(first), markdown.render(second), markdown.render(third)


@dataclass(frozen=True, eq=False)
class Module:
    """A module of the course, with its exercises in order.

    `number` is its name in the course ("L20"), `sessions` its length; `previous` and `next` are numbers of modules.
    `kit` is the source text of `kit/<slug>.py`.
    """

    slug: str
    title: str
    number: str
    summary: str
    track: str
    sessions: int
    prerequisites: tuple[str, ...]
    objectives: tuple[str, ...]
    references: tuple[str, ...]
    previous: str
    next: str
    order: int
    kit: str
    exercises: tuple[Exercise, ...]


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Everything that is served. What is malformed is in `problems` and nowhere else."""

    modules: Mapping[str, Module]
    problems: tuple[Problem, ...]

    @cached_property
    def exercises(self) -> Mapping[str, Exercise]:
        """Exercises by id ("l20/poses"), in the order of the course."""
        return MappingProxyType({one.id: one for module in self.modules.values() for one in module.exercises})

    @cached_property
    def kits(self) -> Mapping[str, str]:
        """Source text of each module's kit, by module."""
        return MappingProxyType({module.slug: module.kit for module in self.modules.values()})
