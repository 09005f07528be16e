"""The files that made the marks of a class, with an index: read one at a time, so that nothing of them is kept."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from uuid import UUID

from server.base.errors import NotFound
from server.course import Course
from server.database import Database
from server.marks import repository
from server.marks.cells import Cell, ascii_slug, french_csv
from server.marks.files import FormatTime, unique_titles
from server.marks.means import round_points
from server.marks.schemas import ExerciseMark, Gradebook, StudentMarks

File = tuple[str, bytes]
INDEX = "index.csv"
NO_SUCH_ASSIGNMENT = "La classe n’a pas ce devoir."
HEADER = ("Fichier", "Devoir", "Exercice", "Élève", "Envoyé le", "Points", "Jours de retard", "Note modifiée")


@dataclass(frozen=True)
class Copy:
    """One attempt that counts, and its line in the index."""

    submission: UUID
    path: str
    line: tuple[Cell, ...]


@dataclass(frozen=True)
class _Called:
    """What a student is called in the index, and in the files' names."""

    name: str
    file: str


def copies(book: Gradebook, course: Course, *, names: bool, only: UUID | None, when: FormatTime) -> Sequence[Copy]:
    """Of every assignment or of one. Without `names`, each student is a number drawn for this archive alone.

    Times of sending are not told then: they would say who it is. Raises NotFound for an assignment of another class.
    """
    if only is not None and all(one.id != only for one in book.assignments):
        raise NotFound(NO_SUCH_ASSIGNMENT)
    called = _names(book.rows) if names else _pseudonyms(book.rows)
    named = unique_titles(book.assignments)
    folders = _unique([ascii_slug(title, "devoir") for title in named])
    found = []
    for place, assignment in enumerate(book.assignments):
        if only is None or assignment.id == only:
            for row in book.rows:
                for one in row.marks[place].exercises:
                    if one.counted is not None:
                        who = called[row.member.id]
                        path = f"{folders[place]}/{_file(course, one.exercise, who.file)}"
                        sent = when(one.sent_at) if names and one.sent_at else ""
                        line = (path, named[place], book.title_of(one.exercise), who.name, sent, *_told(one))
                        found.append(Copy(one.counted.attempt, path, line))
    return found


def _file(course: Course, exercise: str, student: str) -> str:
    known = course.exercises.get(exercise)
    ending = "json" if known is not None and known.answers is not None else "py"
    return f"{exercise.rpartition('/')[2]}/{student}.{ending}"


def _told(one: ExerciseMark) -> tuple[Cell, ...]:
    points = None if one.points is None else round_points(one.points)
    return points, float(one.counted.days_late if one.counted else 0), "oui" if one.override else ""


def _names(rows: Sequence[StudentMarks]) -> Mapping[UUID, _Called]:
    """By family name. Two of one name have files of their own."""
    members = [row.member for row in rows]
    names = [" ".join(filter(None, (one.family_name, one.given_name))) or one.name for one in members]
    files = _unique([ascii_slug(name, "eleve") for name in names])
    return {one.id: _Called(*called) for one, *called in zip(members, names, files, strict=True)}


def _pseudonyms(rows: Sequence[StudentMarks]) -> Mapping[UUID, _Called]:
    """The same through one archive, and of no use with another: drawn with a salt that nobody keeps."""
    salt = secrets.token_bytes(32)
    drawn = sorted((row.member.id for row in rows), key=lambda one: hmac.digest(salt, one.bytes, "sha256"))
    width = len(str(len(drawn)))
    names = [f"eleve-{number:0{width}}" for number in range(1, len(drawn) + 1)]
    return {account_id: _Called(name, name) for account_id, name in zip(drawn, names, strict=True)}


def _unique(names: Sequence[str]) -> list[str]:
    taken: set[str] = set()
    found = []
    for name in names:
        number, unique = 1, name
        while unique in taken:
            number += 1
            unique = f"{name}-{number}"
        taken.add(unique)
        found.append(unique)
    return found


def files_of(database: Database, found: Sequence[Copy]) -> Iterator[File]:
    """The index, then each file, in a transaction of its own; one that is erased meanwhile is left out."""
    yield INDEX, b"".join(french_csv(HEADER, (one.line for one in found)))
    for one in found:
        with database.read() as db:
            source = repository.load_source(db, one.submission)
        if source is not None:
            yield one.path, source
