"""Reading of an exercise's folder: the solution, the named misconceptions, the specimens."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graders.core.code.mutations import Edit, Model
from graders.core.compare.slips import SLIPS
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.outcomes import Outcome

MISCONCEPTIONS = "misconceptions.toml"
MODEL = "model.py"
FIELDS = {"id", "functions", "title", "explanation", "question"}


@dataclass(frozen=True)
class Misconception:
    """A named wrong implementation of `functions`; `source` is a whole submission that makes this mistake.

    Several may share an id: the same mistake gives other outputs in code that, say, also forgets to wrap angles.
    `line` is its line in the catalogue; `whole` means that its source is no edit of the model, `edited` that the
    catalogue has edits for it too, `ruled` that only a rule of the probes recognises it. `right` are checks that pass
    where its words are true ("elsewhere all is right"); `alone`, the parts of its explanation that are true only of a
    program without another mistake ("your poses are right, but ").
    """

    id: str
    functions: tuple[str, ...]
    title: str
    explanation: str
    question: str
    source: str
    line: int = 1
    whole: bool = True
    edited: bool = False
    ruled: bool = False
    right: tuple[str, ...] = ()
    alone: tuple[str, ...] = ()


@dataclass(frozen=True)
class Specimen:
    """A sample submission with its expected outcome."""

    outcome: Outcome
    path: Path


def read_solution(folder: Path) -> str:
    """Return the source of the reference solution. Raises MalformedExerciseError."""
    return _read_text(folder / "solution.py")


def read_misconceptions(folder: Path, solution: str) -> Iterator[Misconception]:
    """Yield the misconceptions of the catalogue, with complete sources. Raises MalformedExerciseError."""
    text, entries = _read_catalogue(folder)
    for entry, line in zip(entries.get("misconception", ()), _find_table_lines(text, "misconception"), strict=False):
        yield from _build_misconceptions(folder, entry, line, solution)


def _read_catalogue(folder: Path) -> tuple[str, dict[str, Any]]:
    path = folder / MISCONCEPTIONS
    text = _read_text(path)
    try:
        entries = tomllib.loads(text)
        _ = entries["misconception"]
    except (tomllib.TOMLDecodeError, KeyError) as error:
        raise MalformedExerciseError(
            path, f"il faut des tables [[misconception]], ou « misconception = [] » ({error})"
        ) from error
    return text, entries


def _find_table_lines(text: str, table: str) -> Iterator[int]:
    """Yield the line numbers of the headers of one array of tables."""
    for header in re.finditer(rf"^[ \t]*\[\[[ \t]*{table}[ \t]*\]\]", text, re.MULTILINE):
        yield text[: header.start()].count("\n") + 1


def _build_misconceptions(folder: Path, entry: dict[str, Any], line: int, solution: str) -> Iterator[Misconception]:
    missing = FIELDS - entry.keys()
    if missing:
        message = f"erreur « {entry.get('id', '?')} » : il manque {', '.join(sorted(missing))}"
        raise MalformedExerciseError(folder / MISCONCEPTIONS, message, line)
    if absent := [text for text in entry.get("alone", ()) if not text or text not in entry["explanation"]]:
        message = f"erreur « {entry['id']} » : « {absent[0]} » (alone) n’est pas dans son explication"
        raise MalformedExerciseError(folder / MISCONCEPTIONS, message, line)
    sources_folder = folder / "misconceptions"
    file = sources_folder / f"{entry['id']}.py"
    files = [
        *([file] if file.exists() or not entry.get("edits") else ()),
        *sorted(sources_folder.glob(f"{entry['id']}__*.py")),
    ]
    sources = [(f"{solution}\n\n{_read_text(path)}", True) for path in files]
    if not sources:
        sources = [(_apply_first_edit(folder, entry, line), False)]
    for source, whole in sources:
        yield Misconception(
            id=entry["id"],
            functions=tuple(entry["functions"]),
            title=entry["title"],
            explanation=entry["explanation"],
            question=entry["question"],
            source=source,
            line=line,
            whole=whole,
            edited=bool(entry.get("edits")),
            ruled=bool(entry.get("ruled")),
            right=tuple(entry.get("right", ())),
            alone=tuple(entry.get("alone", ())),
        )


def _apply_first_edit(folder: Path, entry: dict[str, Any], line: int) -> str:
    """Return the model with the first of a mistake's edits."""
    edited = _parse_edits(entry, folder, line)[0].apply(_read_text(folder / MODEL))
    assert edited is not None, "an edit is tried when it is read"
    return edited


def read_model(folder: Path) -> Model | None:
    """Return the model program with the mistakes that are edits of it; None where an exercise has no model.

    The catalogue lists mistakes under `misconception`, those with the words of a usual slip under `slip`, and other
    correct versions under `style`. Raises MalformedExerciseError for an edit of a text that is absent.
    """
    path = folder / MODEL
    if not path.exists():
        return None
    text, entries = _read_catalogue(folder)
    edits: dict[str, list[Edit]] = {}
    for table in ("style", "misconception", "slip"):
        edits[table] = []
        for entry, line in zip(entries.get(table, ()), _find_table_lines(text, table), strict=False):
            if table == "slip" and entry.get("id") not in SLIPS:
                raise MalformedExerciseError(
                    folder / MISCONCEPTIONS,
                    f"« {entry.get('id')} » n’est pas une étourderie connue : {', '.join(sorted(SLIPS))}",
                    line,
                )
            edits[table] += _parse_edits(entry, folder, line)
    return Model(_read_text(path), (*edits["misconception"], *edits["slip"]), edits["style"])


def _parse_edits(entry: dict[str, Any], folder: Path, line: int) -> list[Edit]:
    """Return the edits of one entry: each is a list of alternating texts, a text and its replacement."""
    model = _read_text(folder / MODEL) if entry.get("edits") else ""
    edits = []
    for texts in entry.get("edits", ()):
        changes = tuple(zip(texts[::2], texts[1::2], strict=True))
        edit = Edit(entry.get("id", ""), changes, frozenset(entry.get("functions", ())))
        if edit.apply(model) is None and not entry.get("after"):
            name = edit.id or "style"
            message = f"« {name} » : ce texte doit se trouver une fois, et une seule, dans {MODEL} : {texts[::2]}"
            raise MalformedExerciseError(folder / MISCONCEPTIONS, message, line)
        edits.append(edit)
    return edits


def check_known_functions(folder: Path, misconceptions: Sequence[Misconception], functions: Sequence[str]) -> None:
    """Raise MalformedExerciseError, with its line, for a misconception of a function that is not requested."""
    for misconception in misconceptions:
        unknown = sorted(set(misconception.functions) - set(functions))
        if unknown:
            message = f"« {misconception.id} » parle de fonctions que l’exercice ne demande pas : {', '.join(unknown)}"
            raise MalformedExerciseError(folder / MISCONCEPTIONS, message, misconception.line)


def read_specimens(folder: Path) -> Iterator[Specimen]:
    """Yield the submissions under `specimens/<outcome>/`. Raises MalformedExerciseError for an unknown outcome."""
    for path in sorted((folder / "specimens").glob("*/*.py")):
        if path.parent.name not in set(Outcome):
            raise MalformedExerciseError(
                path, f"« {path.parent.name} » n’est pas un verdict ; les dossiers de spécimens : {', '.join(Outcome)}"
            )
        yield Specimen(Outcome(path.parent.name), path)


def _read_text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise MalformedExerciseError(path, f"ce fichier manque, ou ne se lit pas ({error.strerror})") from error
