"""The attempts that made the marks of a class, as an archive of files with an index."""

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
from server.marks.cells import Cell, ascii_slug, write_french_csv
from server.marks.files import FormatTime, distinct_assignment_titles
from server.marks.means import round_points
from server.marks.schemas import ExerciseMark, Gradebook, StudentMarks

ArchiveFile = tuple[str, bytes]
INDEX = "index.csv"
NO_SUCH_ASSIGNMENT = "La classe n’a pas ce devoir."
HEADER = (
    "Fichier", "Devoir", "Exercice", "Élève", "Envoyé le", "Points", "Jours de retard", "Note modifiée", "Rendu avec",
)  # fmt: skip


@dataclass(frozen=True)
class CountingAttemptFile:
    """An attempt that counts: its path in the archive, and its line in the index."""

    submission: UUID
    path: str
    line: tuple[Cell, ...]


@dataclass(frozen=True)
class StudentLabel:
    """The name of a student in the index, and in the names of files."""

    name: str
    file_stem: str


def list_counting_attempt_files(
    gradebook: Gradebook, course: Course, *, names: bool, only: UUID | None, format_time: FormatTime
) -> Sequence[CountingAttemptFile]:
    """List the copies of every assignment, or of one. Raise NotFound for an assignment of another class.

    Without `names`, each student gets a pseudonym drawn for this archive alone, and the times of sending are left out,
    which would identify students, and with whom each hands in.
    """
    if only is not None and all(assignment.id != only for assignment in gradebook.assignments):
        raise NotFound(NO_SUCH_ASSIGNMENT)
    labels = _label_by_real_name(gradebook.rows) if names else _label_by_pseudonym(gradebook.rows)
    titles = distinct_assignment_titles(gradebook.assignments)
    folders = _number_duplicate_names([ascii_slug(title, "devoir") for title in titles])
    copies = []
    for index, assignment in enumerate(gradebook.assignments):
        if only is not None and assignment.id != only:
            continue
        for row in gradebook.rows:
            label = labels[row.member.id]
            for mark in row.marks[index].exercises:
                if mark.counted is not None:
                    path = f"{folders[index]}/{_archive_path(course, mark.exercise, label.file_stem)}"
                    sent = format_time(mark.sent_at) if names and mark.sent_at else ""
                    title = gradebook.exercise_title(mark.exercise)
                    partners = ", ".join(row.marks[index].partners) if names else ""
                    line = (path, titles[index], title, label.name, sent, *_mark_cells(mark), partners)
                    copies.append(CountingAttemptFile(mark.counted.attempt, path, line))
    return copies


def _archive_path(course: Course, exercise: str, file_stem: str) -> str:
    known = course.exercises.get(exercise)
    extension = "json" if known is not None and known.answers is not None else "py"
    return f"{exercise.rpartition('/')[2]}/{file_stem}.{extension}"


def _mark_cells(mark: ExerciseMark) -> tuple[Cell, ...]:
    points = None if mark.points is None else round_points(mark.points)
    return points, float(mark.counted.days_late if mark.counted else 0), "oui" if mark.override else ""


def _label_by_real_name(rows: Sequence[StudentMarks]) -> Mapping[UUID, StudentLabel]:
    """Label students by family name, with different file names for equal names."""
    students = [row.member for row in rows]
    names = [" ".join(filter(None, (student.family_name, student.given_name))) or student.name for student in students]
    stems = _number_duplicate_names([ascii_slug(name, "eleve") for name in names])
    return {student.id: StudentLabel(name, stem) for student, name, stem in zip(students, names, stems, strict=True)}


def _label_by_pseudonym(rows: Sequence[StudentMarks]) -> Mapping[UUID, StudentLabel]:
    """Label students by numbers that hold for one archive: drawn with a salt that is not stored."""
    salt = secrets.token_bytes(32)
    students = sorted((row.member.id for row in rows), key=lambda id: hmac.digest(salt, id.bytes, "sha256"))
    width = len(str(len(students)))
    names = [f"eleve-{number:0{width}}" for number in range(1, len(students) + 1)]
    return {account_id: StudentLabel(name, name) for account_id, name in zip(students, names, strict=True)}


def _number_duplicate_names(names: Sequence[str]) -> list[str]:
    """Append numbers to names that occur before."""
    taken: set[str] = set()
    unique_names = []
    for name in names:
        number, unique_name = 1, name
        while unique_name in taken:
            number += 1
            unique_name = f"{name}-{number}"
        taken.add(unique_name)
        unique_names.append(unique_name)
    return unique_names


def iter_archive_files(database: Database, copies: Sequence[CountingAttemptFile]) -> Iterator[ArchiveFile]:
    """Yield the index, then each file, read in a transaction of its own; files erased meanwhile are left out."""
    yield INDEX, b"".join(write_french_csv(HEADER, (copy.line for copy in copies)))
    for copy in copies:
        with database.read() as db:
            source = repository.load_submission_source(db, copy.submission)
        if source is not None:
            yield copy.path, source
