"""Definition of a declared exercise by its folder: `declaration.toml` and `solution.py`, which is data here."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from graders.core.contract.definition import Definition
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.declared.declaration import Declaration, read_declaration
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.malformed import MalformedDeclaration

DECLARATION, SOLUTION = "declaration.toml", "solution.py"


@dataclass(frozen=True)
class DeclaredDefinition(Definition):
    """See `declared`."""

    declaration: Declaration

    @property
    def judged_functions(self) -> frozenset[str]:
        """The functions that some check tests."""
        return frozenset(self.declaration.functions)

    def bind(self, functions: Sequence[str]) -> DeclaredGrader:
        """Return the grader of an exercise that asks for `functions`."""
        return DeclaredGrader(self.exercise, self.declaration, self.folder)


def declared(file: str) -> DeclaredDefinition:
    """Describe an exercise from its grader's module: `DEFINITION = declared(__file__)`.

    Raises MalformedExerciseError when the folder is inconsistent.
    """
    folder = Path(file).parent
    path = folder / DECLARATION
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
        solution = (folder / SOLUTION).read_text(encoding="utf-8")
        return DeclaredDefinition(folder, read_declaration({**data, "solution": solution}))
    except OSError as error:
        raise MalformedExerciseError(
            Path(error.filename or path), f"ce fichier manque, ou ne se lit pas ({error.strerror})"
        ) from error
    except (tomllib.TOMLDecodeError, MalformedDeclaration) as error:
        raise MalformedExerciseError(path, str(error)) from error
