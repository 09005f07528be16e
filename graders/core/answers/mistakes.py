"""The misconceptions of an exercise answered without code: `misconceptions.toml`, as for code, without files."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.verdict import Diagnosis

FIELDS = {"id", "title", "explanation", "question"}


@dataclass(frozen=True)
class Mistake:
    """A named wrong idea; `question` makes the student see it."""

    id: str
    title: str
    explanation: str
    question: str

    @property
    def brief_text(self) -> str:
        """The short text for a check; the diagnosis has the explanation."""
        return f"{self.title.strip().rstrip('.')}. {self.question.strip()}"

    @property
    def to_diagnosis(self) -> Diagnosis:
        return Diagnosis(self.id, self.title, f"{self.explanation.strip()}\n\n{self.question.strip()}")


def read_mistakes(folder: Path) -> Mapping[str, Mistake]:
    """Return the mistakes by id, in the order of the file; {} without a file. Raises MalformedExerciseError."""
    path = folder / "misconceptions.toml"
    if not path.is_file():
        return {}
    try:
        entries = tomllib.loads(path.read_text(encoding="utf-8"))["misconception"]
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, KeyError) as error:
        raise MalformedExerciseError(path, f"il faut des tables [[misconception]] ({error})") from error
    mistakes: dict[str, Mistake] = {}
    for entry in entries:
        name = entry.get("id", "?")
        if entry.keys() != FIELDS or not all(isinstance(value, str) and value.strip() for value in entry.values()):
            raise MalformedExerciseError(
                path, f"erreur « {name} » : il faut {', '.join(sorted(FIELDS))}, et rien d’autre"
            )
        if name in mistakes:
            raise MalformedExerciseError(path, f"deux erreurs se nomment « {name} »")
        mistakes[name] = Mistake(**entry)
    return mistakes


def check_same_mistakes(folder: Path, catalogued: Mapping[str, Mistake], used: set[str]) -> None:
    """Raise MalformedExerciseError unless the catalogue holds exactly the mistakes that the exercise uses."""
    path = folder / "misconceptions.toml"
    for name in sorted(used ^ catalogued.keys()):
        where = "une réponse y mène, mais elle n’est pas ici" if name in used else "aucune réponse n’y mène"
        raise MalformedExerciseError(path, f"erreur « {name} » : {where}")
