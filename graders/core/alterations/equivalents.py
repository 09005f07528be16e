"""Equivalent mutants of an exercise: alterations of its solution that are still right, listed in `equivalents.toml`.

A mark identifies an alteration by its function and its lines before and after, and becomes stale when the solution
changes.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from graders.core.alterations.alterations import Alteration
from graders.core.contract.malformed import MalformedExerciseError

EQUIVALENTS = "equivalents.toml"
FIELDS = ("function", "removed", "added", "reason")
_HEADER = re.compile(r"^[ \t]*\[\[[ \t]*equivalent[ \t]*\]\]", re.MULTILINE)


@dataclass(frozen=True)
class EquivalentMark:
    """An alteration declared equivalent; `removed` and `added` are its lines without indentation."""

    file: Path
    line: int
    function: str
    removed: tuple[str, ...]
    added: tuple[str, ...]
    reason: str

    def matches(self, alteration: Alteration) -> bool:
        return (self.function, self.removed, self.added) == (
            alteration.function,
            alteration.removed_lines,
            alteration.added_lines,
        )


def read_equivalents(folder: Path) -> tuple[EquivalentMark, ...]:
    """Return the marks of an exercise; () without a file.

    Raises MalformedExerciseError, with the line, for a mark with missing, unknown or empty fields.
    """
    path = folder / EQUIVALENTS
    if not path.exists():
        return ()
    text = path.read_text(encoding="utf-8")
    try:
        read = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise MalformedExerciseError(path, f"ce n’est pas du TOML ({error})") from error
    entries = read.pop("equivalent", None)
    if read or not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise MalformedExerciseError(path, "il faut des tables [[equivalent]]")
    starts = [text[: header.start()].count("\n") + 1 for header in _HEADER.finditer(text)]
    if len(starts) != len(entries):
        raise MalformedExerciseError(path, "chaque marque commence par une ligne [[equivalent]]")
    marks = tuple(_parse_mark(path, entry, line) for entry, line in zip(entries, starts, strict=True))
    _reject_duplicates(marks)
    return marks


def _parse_mark(path: Path, entry: dict[str, object], line: int) -> EquivalentMark:
    if odd := sorted(set(FIELDS) ^ entry.keys()):
        raise MalformedExerciseError(path, f"ces champs manquent, ou sont de trop : {', '.join(odd)}", line)
    texts = [entry[name] for name in FIELDS]
    if not all(isinstance(text, str) for text in texts):
        raise MalformedExerciseError(path, "chaque champ d’une marque est un texte", line)
    function, removed, added, reason = map(str, texts)
    if not reason.strip() or not removed.strip():
        raise MalformedExerciseError(path, "une marque dit de quelles lignes elle parle, et pourquoi", line)
    return EquivalentMark(path, line, function, _strip_lines(removed), _strip_lines(added), reason.strip())


def _strip_lines(text: str) -> tuple[str, ...]:
    return tuple(line.strip() for line in text.strip("\n").splitlines())


def _reject_duplicates(marks: Sequence[EquivalentMark]) -> None:
    seen: set[tuple[object, ...]] = set()
    for mark in marks:
        key = (mark.function, mark.removed, mark.added)
        if key in seen:
            raise MalformedExerciseError(mark.file, "la même marque est déjà plus haut", mark.line)
        seen.add(key)


def find_stale_marks(marks: Sequence[EquivalentMark], found: Sequence[Alteration]) -> Iterator[MalformedExerciseError]:
    """Yield an error for each mark that matches no alteration."""
    for mark in marks:
        if not any(mark.matches(alteration) for alteration in found):
            words = "aucune altération de la solution n’a plus cette fonction et ces lignes"
            yield MalformedExerciseError(mark.file, words, mark.line)
