"""The marks of a class as tables: for a spreadsheet, for Moodle, for programs, and as one column to copy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import Any

from server.assignments.models import Assignment, Mode
from server.classes.schemas import StudentRecord
from server.marks.cells import Cell, Sheet, ascii_slug, escape_formula, plain_csv
from server.marks.means import format_number, round_points
from server.marks.schemas import AssignmentMark, ExerciseMark, Gradebook, MarkState, MarkSummary, is_withheld

ABSENT, EXCUSED, AVERAGE = "Abs", "disp.", "Moyenne"
FormatTime = Callable[[datetime], str]
YES = {True: "oui", False: ""}
STATE_TEXTS = {MarkState.absent: ABSENT, MarkState.excused: EXCUSED}


class MoodleIdentifier(StrEnum):
    """The column by which Moodle identifies students."""

    email = "email"
    id = "id"


def file_name(gradebook: Gradebook, contents: str, extension: str) -> str:
    """Return an ASCII file name: « balise-mpsi-2-notes-2026-11-22.csv »."""
    return f"balise-{ascii_slug(gradebook.school_class.name, 'classe')}-{contents}-{gradebook.at:%Y-%m-%d}.{extension}"


def mark_cell(mark: AssignmentMark) -> Cell:
    """Return points, « Abs », « disp. », or None."""
    if mark.state in STATE_TEXTS:
        return STATE_TEXTS[mark.state]
    return _round_or_none(mark.points)


def unique_titles(assignments: Sequence[Assignment]) -> tuple[str, ...]:
    """Return the titles of assignments, numbered where several have the same."""
    counts: Counter[str] = Counter()
    titles = []
    for assignment in assignments:
        title = assignment.title
        counts[title] += 1
        titles.append(title if counts[title] == 1 else f"{title} ({counts[title]})")
    return tuple(titles)


def _person(student: StudentRecord) -> tuple[str, str, str, str]:
    """Return family name, given name, login and groups; the whole name first where the list has no family name."""
    names = (student.family_name, student.given_name) if student.family_name else (student.name, "")
    return *names, student.login, ", ".join(student.groups)


PERSON = ("Nom", "Prénom", "Identifiant", "Groupe")


def marks_sheet(gradebook: Gradebook) -> Sheet:
    """Return the table of students × assignments, with the averages."""
    rows = [
        (*_person(row.member), *(mark_cell(mark) for mark in row.marks), _round_or_none(row.average))
        for row in gradebook.rows
    ]
    return Sheet("Notes", (*PERSON, *unique_titles(gradebook.assignments), AVERAGE), rows, frozen=2)


DETAILS = ("Points", "Note automatique", "Dispensé", "Jours de retard", "Essais", "Note modifiée", "À revoir", "Motif")


def exercises_sheet(gradebook: Gradebook) -> Sheet:
    """Return a table with a line for each student, assignment and exercise."""
    titles = unique_titles(gradebook.assignments)
    rows = [
        (*_person(row.member), title, gradebook.title_of(exercise.exercise), *_details(exercise, mark))
        for row in gradebook.rows
        for title, mark in zip(titles, row.marks, strict=True)
        for exercise in mark.exercises
    ]
    return Sheet("Exercices", (*PERSON, "Devoir", "Exercice", *DETAILS), rows, frozen=2)


def _details(exercise: ExerciseMark, mark: AssignmentMark) -> tuple[Cell, ...]:
    excused = exercise.excused or mark.state is MarkState.excused
    return (
        None if excused else _round_or_none(exercise.points),
        _round_or_none(exercise.effective.automatic),
        YES[excused],
        float(exercise.days_late),
        float(exercise.attempts),
        YES[exercise.override is not None],
        YES[exercise.stale],
        exercise.override.reason if exercise.override else "",
    )


def explanations_sheet(gradebook: Gradebook, format_time: FormatTime) -> Sheet:
    """Return the table of assignments with weights, dates, mean and median, followed by the notes."""
    rows: list[tuple[Cell, ...]] = []
    for index, assignment in enumerate(gradebook.assignments):
        dates = (assignment.opens_at, assignment.due_at, assignment.closes_at)
        remark = "contrôle, pas encore rendu aux élèves" if is_withheld(assignment, gradebook.at) else ""
        title, summary = unique_titles(gradebook.assignments)[index], gradebook.summary_of(index)
        texts = (format_time(date) if date else "" for date in dates)
        rows.append((title, assignment.weight, *texts, remark, *_summary_cells(summary)))
    rows.append((AVERAGE, None, "", "", "", "", *_summary_cells(gradebook.averages)))
    notes = (*NOTES, f"Notes du {format_time(gradebook.at)}.")
    rows += [("",) + (None,) * 8] + [(note, *[None] * 8) for note in notes]
    header = ("Devoir", "Coefficient", "Ouvre", "À rendre", "Ferme", "Remarque", "Copies", "Moyenne", "Médiane")
    return Sheet("Explications", header, rows, frozen=1)


def _summary_cells(summary: MarkSummary) -> tuple[Cell, ...]:
    return float(summary.count), _round_or_none(summary.mean), _round_or_none(summary.median)


NOTES = (
    "Les notes sont sur 20, arrondies au centième ; les moyennes sont faites sur les points exacts.",
    f"« {ABSENT} » : le devoir est fini et rien n’a été envoyé ; il compte 0 dans la moyenne de l’élève.",
    f"« {EXCUSED} » : dispensé ; le devoir ou l’exercice ne compte pas dans la moyenne.",
    "Un devoir est fini quand plus rien ne peut être envoyé ; s’il ne ferme pas, quand sa date de rendu est passée.",
    "Fini, un exercice sans essai compte 0. En cours, seuls comptent les exercices envoyés, et le devoir n’entre pas "
    "encore dans la moyenne de l’élève. Un devoir sans date compte dès le premier envoi, sur ce qui est envoyé.",
    "La moyenne et la médiane de la classe sont celles des copies envoyées : ni absents, ni dispensés.",
)


def gradebook_sheets(gradebook: Gradebook, format_time: FormatTime) -> tuple[Sheet, ...]:
    return marks_sheet(gradebook), exercises_sheet(gradebook), explanations_sheet(gradebook, format_time)


def column_text(gradebook: Gradebook, index: int | None) -> str:
    """Return the marks at an assignment, or the averages (None): one a line, in the order of the list of names."""
    cells: list[Cell] = [
        _round_or_none(row.average) if index is None else mark_cell(row.marks[index]) for row in gradebook.rows
    ]
    return "\n".join("" if cell is None else cell if isinstance(cell, str) else format_number(cell) for cell in cells)


@dataclass(frozen=True)
class MoodleFile:
    """A table that Moodle imports; `left_out`: the names of students who cannot be in it."""

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    left_out: tuple[str, ...]

    def lines(self) -> Iterator[bytes]:
        return plain_csv(self.header, self.rows)


COLUMNS = {MoodleIdentifier.email: "Email address", MoodleIdentifier.id: "ID number"}


def moodle_file(gradebook: Gradebook, identifier: MoodleIdentifier) -> MoodleFile:
    """Return the final marks; an empty cell leaves Moodle's mark as it is.

    Tests that are not released are left out, as Moodle would show them; so are students without an identifier of their
    own.
    """
    titles = unique_titles(gradebook.assignments)
    shown = [n for n, assignment in enumerate(gradebook.assignments) if not is_withheld(assignment, gradebook.at)]
    uses = Counter(_moodle_identity(row.member, identifier) for row in gradebook.rows)
    rows, left_out = [], []
    for row in gradebook.rows:
        identity = _moodle_identity(row.member, identifier)
        if not identity or uses[identity] > 1 or escape_formula(identity) != identity:
            left_out.append(row.member.name)
        else:
            rows.append((identity, *(_final_points(row.marks[index]) for index in shown)))
    header = (COLUMNS[identifier], *(titles[index] for index in shown))
    return MoodleFile(header, tuple(rows), tuple(left_out))


def _moodle_identity(student: StudentRecord, identifier: MoodleIdentifier) -> str:
    return student.email.strip().casefold() if identifier is MoodleIdentifier.email else student.login


def _final_points(mark: AssignmentMark) -> float | None:
    cell = mark_cell(mark)
    return None if isinstance(cell, str) or mark.in_average is None else cell


def gradebook_json(gradebook: Gradebook) -> dict[str, Any]:
    """Return the whole gradebook as plain values (contract, section 6)."""
    school_class = gradebook.school_class
    return {
        "class": {"id": school_class.id, "name": school_class.name, "module": school_class.module},
        "generated_at": gradebook.at,
        "assignments": [_assignment_json(gradebook, index) for index in range(len(gradebook.assignments))],
        "students": [
            {
                "id": row.member.id,
                "name": row.member.name,
                "groups": list(row.member.groups),
                "average": _round_or_none(row.average),
                "marks": [
                    _assignment_mark_json(assignment, mark)
                    for assignment, mark in zip(gradebook.assignments, row.marks, strict=True)
                ],
            }
            for row in gradebook.rows
        ],
    }


def _assignment_json(gradebook: Gradebook, index: int) -> dict[str, Any]:
    assignment, summary = gradebook.assignments[index], gradebook.summary_of(index)
    return {
        "id": assignment.id,
        "title": assignment.title,
        "mode": Mode(assignment.mode),
        "weight": assignment.weight,
        "opens_at": assignment.opens_at,
        "due_at": assignment.due_at,
        "closes_at": assignment.closes_at,
        "held_back": is_withheld(assignment, gradebook.at),
        "exercises": [
            {"exercise": exercise, "weight": weight} for exercise, weight in gradebook.exercises[assignment.id]
        ],
        "copies": summary.count,
        "mean": _round_or_none(summary.mean),
        "median": _round_or_none(summary.median),
    }


def _assignment_mark_json(assignment: Assignment, mark: AssignmentMark) -> dict[str, Any]:
    return {
        "assignment": assignment.id,
        "state": mark.state,
        "points": _round_or_none(mark.points),
        "days_late": mark.days_late,
        "exercises": [exercise_mark_json(exercise) for exercise in mark.exercises],
    }


def exercise_mark_json(mark: ExerciseMark) -> dict[str, Any]:
    override = mark.override
    return {
        "exercise": mark.exercise,
        "points": _round_or_none(mark.points),
        "automatic": _round_or_none(mark.effective.automatic),
        "excused": mark.excused,
        "days_late": mark.days_late,
        "attempts": mark.attempts,
        "override": None
        if override is None
        else {
            "points": _round_or_none(override.points),
            "excused": override.excused,
            "reason": override.reason,
            "by": override.by or None,
            "at": override.at,
            "stale": mark.stale,
        },
    }


def _round_or_none(points: float | None) -> float | None:
    return None if points is None else round_points(points)
