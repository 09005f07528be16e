"""The shapes of the TOML files that an author writes, as models: what editors complete, what is documented.

Those of a course's texts are read by these very models. The catalogues of mistakes are read by the graders, which are
lenient with a key that they do not know; here nothing unknown goes unnoticed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, Field

from server.course import toml_file
from server.course.models import Course, CourseFault, Problem
from server.course.questions import ChoiceFile, NumericFile, OrderFile
from server.course.schemas import (
    ExerciseFamiliesFile,
    ExerciseFile,
    FamiliesFile,
    FrontMatter,
    ModuleFile,
    StrictModel,
    TermEntry,
    Text,
)

#: A text of the model to replace, and what replaces it, as often as one likes.
Edit = Annotated[list[str], Field(min_length=2)]
MISCONCEPTIONS = "misconceptions.toml"


class MisconceptionEntry(StrictModel):
    """One `[[misconception]]` of an exercise of code."""

    id: Text
    functions: Annotated[list[Text], Field(min_length=1)]
    title: Text
    explanation: Text
    question: Text
    edits: list[Edit] = Field(default_factory=list)
    ruled: bool = False
    right: list[Text] = Field(default_factory=list)
    alone: list[str] = Field(default_factory=list)
    after: bool = False


class SlipEntry(StrictModel):
    """One `[[slip]]`: edits of the model that make a usual slip, whose words are known."""

    id: Text
    edits: list[Edit]
    functions: list[Text] = Field(default_factory=list)
    after: bool = False


class StyleEntry(StrictModel):
    """One `[[style]]`: edits of the model that leave it right."""

    edits: list[Edit]


class MisconceptionsFile(StrictModel):
    """`graders/<module>/<slug>/misconceptions.toml` of an exercise of code."""

    misconception: list[MisconceptionEntry] = Field(default_factory=list)
    slip: list[SlipEntry] = Field(default_factory=list)
    style: list[StyleEntry] = Field(default_factory=list)


class MistakeEntry(StrictModel):
    """One `[[misconception]]` of an exercise without code."""

    id: Text
    title: Text
    explanation: Text
    question: Text


class MistakesFile(StrictModel):
    """`misconceptions.toml` of an exercise without code."""

    misconception: list[MistakeEntry] = Field(default_factory=list)


class EquivalentEntry(StrictModel):
    """One `[[equivalent]]`: an alteration of the solution that is still right."""

    function: str
    removed: str
    added: str
    reason: Text


class EquivalentsFile(StrictModel):
    """`graders/<module>/<slug>/equivalents.toml`."""

    equivalent: list[EquivalentEntry] = Field(default_factory=list)


class GlossaryFile(StrictModel):
    """`curriculum/<module>/glossaire.toml`."""

    terme: list[TermEntry]


@dataclass(frozen=True)
class FileShape:
    """A kind of file: `model` of all of it (or of its front matter), `places` below the folder of a course."""

    name: str
    model: type[BaseModel] | tuple[type[BaseModel], ...]
    path_patterns: tuple[str, ...]


SHAPES = (
    FileShape("module", ModuleFile, ("curriculum/*/module.toml",)),
    FileShape("glossaire", GlossaryFile, ("curriculum/*/glossaire.toml",)),
    FileShape("exercise", ExerciseFile, ("curriculum/*/exercices/*/exercise.toml",)),
    FileShape("questions", (ChoiceFile, OrderFile, NumericFile), ("curriculum/*/exercices/*/questions.toml",)),
    FileShape("misconceptions", MisconceptionsFile, ("graders/*/*/misconceptions.toml",)),
    FileShape("mistakes", MistakesFile, ("curriculum/*/exercices/*/misconceptions.toml",)),
    FileShape("equivalents", EquivalentsFile, ("graders/*/*/equivalents.toml",)),
    FileShape("families", FamiliesFile, ("curriculum/families.toml",)),
    FileShape("exercise_families", ExerciseFamiliesFile, ("curriculum/*/exercices/*/families.toml",)),
    FileShape("entete", FrontMatter, ()),
)


def find_catalogue_faults(course: Course) -> Iterator[Problem]:
    """What the catalogues of mistakes hold that nothing reads, or lack."""
    for exercise in course.exercises.values():
        folder = exercise.statement.source.path.parent
        graders = getattr(exercise.grader, "folder", folder)
        model: type[BaseModel] = MisconceptionsFile if exercise.answers is None else MistakesFile
        for path, shape in ((graders / MISCONCEPTIONS, model), (graders / "equivalents.toml", EquivalentsFile)):
            if path.is_file():
                yield from _find_file_faults(path, shape)


def _find_file_faults(path: Path, model: type[BaseModel]) -> Iterator[Problem]:
    try:
        toml_file.read_toml(path, model)
    except CourseFault as fault:
        yield fault.problem
