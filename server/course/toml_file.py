"""Reading a TOML file into a strict model, with the line of each fault."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from server.base.validation import french_reason
from server.course.models import CourseFault, Problem
from server.course.toml_places import Location, find_line_of_value

M = TypeVar("M", bound=BaseModel)

MESSAGES = {
    "missing": "champ manquant : « {field} »",
    "extra_forbidden": "champ inconnu : « {field} »",
    "plain_text": "« {field} » : ni formule ni code dans ce texte",
}


def read_text(path: Path) -> str:
    """The file's text. Raises CourseFault when it is missing or not UTF-8."""
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise CourseFault(Problem(path, None, "fichier manquant")) from None
    except UnicodeDecodeError as error:
        line = path.read_bytes()[: error.start].count(b"\n") + 1
        raise CourseFault(Problem(path, line, "ce fichier n’est pas en UTF-8")) from error


def read_toml(path: Path, model: type[M]) -> M:
    """Read and validate. Raises CourseFault with the place of the first fault."""
    return parse_toml(read_text(path), path, model)


def parse_toml(text: str, path: Path, model: type[M], first_line: int = 1) -> M:
    """Validate a TOML text that stands at `first_line` of a file. Raises CourseFault like `read_toml`."""
    return validate_values(parse_toml_values(text, path, first_line), text, path, model, first_line=first_line)


def validate_values(values: object, text: str, path: Path, model: type[M], at: Location = (), first_line: int = 1) -> M:
    """Validate what stands at `at` in the TOML text. Raises CourseFault with the place of the first fault."""
    try:
        return model.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        line = find_line_of_value(text, (*at, *first["loc"])) + first_line - 1
        raise CourseFault(Problem(path, line, describe_validation_error(first))) from error


def parse_toml_values(text: str, path: Path, first_line: int = 1) -> dict[str, Any]:
    """The values of a TOML text. Raises CourseFault when it is not TOML."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = syntax_error_line(text, error) + first_line - 1
        raise CourseFault(Problem(path, line, f"TOML mal formé ({error})")) from error


def describe_validation_error(fault: ErrorDetails) -> str:
    """A French sentence for one of pydantic's faults."""
    field = ".".join(str(part + 1) if isinstance(part, int) else part for part in fault["loc"])
    own = MESSAGES.get(fault["type"])
    return own.format(field=field) if own else f"« {field} » : {french_reason(fault)}"


def syntax_error_line(text: str, error: tomllib.TOMLDecodeError) -> int:
    """tomllib states the line in its message only ("at line 3, column 5" or "at end of document")."""
    match = re.search(r"at line (\d+)", str(error))
    return int(match[1]) if match else max(1, len(text.splitlines()))
