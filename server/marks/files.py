"""The marks of a class as tables: for a spreadsheet, for Moodle, for programs, and as one column to copy."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from server.assignments.models import Assignment
from server.classes.schemas import StudentRecord
from server.marks.cells import Cell, WorkbookSheet, ascii_slug, escape_formula, write_plain_csv
from server.marks.means import FORMULA, format_number, round_or_none, round_points
from server.marks.schemas import (
    AssignmentMark,
    ColumnMark,
    ExerciseMark,
    Gradebook,
    MarkStatistics,
    StudentMarks,
    is_test_withheld,
)
from server.marks.states import STATE_WORDS, UNMARKED_STATES, WHOLE_STATES, Counting, MarkingRules, MarkState

AVERAGE = "Moyenne"
FormatTime = Callable[[datetime], str]
YES = {True: "oui", False: ""}


class MoodleIdentifier(StrEnum):
    """The column by which Moodle identifies students."""

    email = "email"
    id = "id"


def gradebook_file_name(gradebook: Gradebook, contents: str, extension: str) -> str:
    """Return an ASCII file name: « balise-mpsi-2-notes-2026-11-22.csv »."""
    return f"balise-{ascii_slug(gradebook.school_class.name, 'classe')}-{contents}-{gradebook.at:%Y-%m-%d}.{extension}"


def assignment_value_cell(mark: AssignmentMark) -> Cell:
    """Return points, or the state in words where there are none."""
    if mark.state in UNMARKED_STATES or mark.points is None:
        return french_state_words(mark.state)
    return round_points(mark.points)


def column_value_cell(mark: ColumnMark) -> Cell:
    """Return the points out of the column's own scale, or the state in words; None where nothing was typed."""
    if mark.typed.points is not None:
        return mark.typed.points
    return None if mark.typed.state is None else STATE_WORDS[mark.state]


def exercise_value_cell(exercise: ExerciseMark, mark: AssignmentMark) -> Cell:
    """Return the points of an exercise, or its state in words where there are none."""
    state = exercise.state_within(mark.state)
    if state in STATE_WORDS and (exercise.points is None or state in WHOLE_STATES):
        return french_state_words(state)
    return round_or_none(exercise.points)


def french_state_words(state: MarkState) -> str:
    """Return the words of a state; empty for one that has points."""
    return STATE_WORDS.get(state, "")


def distinct_assignment_titles(assignments: Sequence[Assignment]) -> tuple[str, ...]:
    """Return the titles of assignments, numbered where several have the same."""
    return _number_duplicate_titles([assignment.title for assignment in assignments])


def _number_duplicate_titles(titles: Sequence[str]) -> tuple[str, ...]:
    counts: Counter[str] = Counter()
    numbered = []
    for title in titles:
        counts[title] += 1
        numbered.append(title if counts[title] == 1 else f"{title} ({counts[title]})")
    return tuple(numbered)


def person_cells(student: StudentRecord) -> tuple[str, str, str, str]:
    """Return family name, given name, login and groups; the whole name first where the list has no family name."""
    names = (student.family_name, student.given_name) if student.family_name else (student.name, "")
    return *names, student.login, ", ".join(student.groups)


PERSON = ("Nom", "Prénom", "Identifiant", "Groupe")


def build_marks_sheet(gradebook: Gradebook) -> WorkbookSheet:
    """Return the table of students × assignments and columns, with the averages."""
    rows = [
        (
            *person_cells(row.member),
            *(assignment_value_cell(mark) for mark in row.marks),
            *(column_value_cell(mark) for mark in row.columns),
            round_or_none(row.average),
        )
        for row in gradebook.rows
    ]
    titles = (*distinct_assignment_titles(gradebook.assignments), *(column.full_title for column in gradebook.columns))
    return WorkbookSheet("Notes", (*PERSON, *_number_duplicate_titles(titles), AVERAGE), rows, frozen=2)


DETAILS = (
    "Points", "Note automatique", "État", "Jours de retard", "Essais", "Note modifiée", "Portée", "À revoir", "Motif",
    "Rendu avec",
)  # fmt: skip
SCOPES = {True: "tous les devoirs", False: "ce devoir"}


def build_exercises_sheet(gradebook: Gradebook) -> WorkbookSheet:
    """Return a table with a line for each student, assignment and exercise."""
    titles = distinct_assignment_titles(gradebook.assignments)
    rows = [
        (
            *person_cells(row.member),
            title,
            gradebook.exercise_title(exercise.exercise),
            *_exercise_detail_cells(exercise, mark),
        )
        for row in gradebook.rows
        for title, mark in zip(titles, row.marks, strict=True)
        for exercise in mark.exercises
    ]
    return WorkbookSheet("Exercices", (*PERSON, "Devoir", "Exercice", *DETAILS), rows, frozen=2)


def _exercise_detail_cells(exercise: ExerciseMark, mark: AssignmentMark) -> tuple[Cell, ...]:
    state, override = exercise.state_within(mark.state), exercise.override
    return (
        None if state in WHOLE_STATES else round_or_none(exercise.points),
        round_or_none(exercise.effective.automatic),
        french_state_words(state),
        float(exercise.days_late),
        float(exercise.attempts),
        YES[override is not None],
        SCOPES[override.assignment_id is None] if override else "",
        YES[exercise.stale],
        override.reason if override else "",
        ", ".join(mark.partners),
    )


def build_explanations_sheet(gradebook: Gradebook, format_time: FormatTime) -> WorkbookSheet:
    """Return the table of assignments with weights, dates, mean and median, followed by the notes."""
    rows: list[tuple[Cell, ...]] = []
    for index, assignment in enumerate(gradebook.assignments):
        dates = (assignment.opens_at, assignment.due_at, assignment.closes_at)
        remark = "contrôle, pas encore publié" if is_test_withheld(assignment, gradebook.at) else ""
        title, summary = (
            distinct_assignment_titles(gradebook.assignments)[index],
            gradebook.assignment_statistics(index),
        )
        texts = (format_time(date) if date else "" for date in dates)
        rows.append((title, assignment.weight, *texts, remark, *_summary_cells(summary)))
    for index, column in enumerate(gradebook.columns):
        when = "" if column.taken_on is None else f"{column.taken_on:%d/%m/%Y}"
        remark = "bonus" if column.bonus else "colonne"
        remark += "" if column.published_at else ", pas encore publiée aux élèves"
        summary = gradebook.column_statistics(index)
        weight = None if column.bonus else column.weight
        rows.append((column.full_title, weight, when, "", "", remark, *_summary_cells(summary)))
    rows.append((AVERAGE, None, "", "", "", "", *_summary_cells(gradebook.average_statistics)))
    notes = (*explain_marking_rules(gradebook.marking), f"Notes du {format_time(gradebook.at)}.")
    rows += [("",) + (None,) * 8] + [(note, *[None] * 8) for note in notes]
    header = ("Devoir", "Coefficient", "Ouvre", "À rendre", "Ferme", "Remarque", "Copies", "Moyenne", "Médiane")
    return WorkbookSheet("Explications", header, rows, frozen=1)


def _summary_cells(summary: MarkStatistics) -> tuple[Cell, ...]:
    return float(summary.count), round_or_none(summary.mean), round_or_none(summary.median)


COUNTED_WORDS = {Counting.zero: "compte 0 dans la moyenne", Counting.ignore: "ne compte pas dans la moyenne"}


def explain_marking_rules(marking: MarkingRules) -> tuple[str, ...]:
    """Return how marks are made in a class, in sentences."""
    blank = COUNTED_WORDS[marking.unanswered].replace("la moyenne", "sa note")
    return (
        f"{FORMULA}.",
        "Les notes sont sur 20, arrondies au centième ; les moyennes sont faites sur les points exacts. Une colonne a "
        "son propre barème ; un bonus s’ajoute tel quel à la moyenne.",
        f"« non rendu » : le devoir est fini et rien n’a été envoyé ; il {COUNTED_WORDS[marking.not_handed_in]}.",
        f"« refusé (retard) » : tout est venu trop tard ; le devoir {COUNTED_WORDS[marking.late_refused]}.",
        f"« absent » : un enseignant l’a dit ; la note {COUNTED_WORDS[marking.absent]}.",
        "« dispensé » : le devoir ou l’exercice ne compte pas dans la moyenne. « non concerné » : donné à d’autres "
        "groupes, ne compte pas. « à venir » : pas encore dû, ne compte pas. « 0 » : une note comme une autre.",
        "Un devoir est fini quand plus rien ne peut être envoyé ; s’il ne ferme pas, quand sa date de rendu est "
        "passée.",
        f"D’un devoir rendu, un exercice sans réponse {blank}. En cours, seuls comptent les exercices envoyés, "
        "et le devoir n’entre pas encore dans la moyenne de l’élève. "
        "Un devoir sans date compte dès le premier envoi, sur ce qui est envoyé.",
        "La moyenne et la médiane de la classe sont celles des notes chiffrées : sans les non rendus, les absents ni "
        "les dispensés.",
    )


def build_gradebook_sheets(gradebook: Gradebook, format_time: FormatTime) -> tuple[WorkbookSheet, ...]:
    return (
        build_marks_sheet(gradebook),
        build_exercises_sheet(gradebook),
        build_explanations_sheet(gradebook, format_time),
    )


def marks_as_lines(gradebook: Gradebook, name: str | None) -> str:
    """Return the marks of the assignment or column with this id, or the averages (None): one a line, in the order of
    the list of names."""
    cells = [_find_student_cell(gradebook, row, name) for row in gradebook.rows]
    return "\n".join("" if cell is None else cell if isinstance(cell, str) else format_number(cell) for cell in cells)


def _find_student_cell(gradebook: Gradebook, row: StudentMarks, name: str | None) -> Cell:
    if name is None:
        return round_or_none(row.average)
    for column_mark in row.columns:
        if str(column_mark.column.id) == name:
            return column_value_cell(column_mark)
    (mark,) = (
        mark for assignment, mark in zip(gradebook.assignments, row.marks, strict=True) if str(assignment.id) == name
    )
    return assignment_value_cell(mark)


@dataclass(frozen=True)
class MoodleTable:
    """A table that Moodle imports; `left_out`: the names of students who cannot be in it."""

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    left_out: tuple[str, ...]

    def iter_csv_lines(self) -> Iterator[bytes]:
        return write_plain_csv(self.header, self.rows)


COLUMNS = {MoodleIdentifier.email: "Email address", MoodleIdentifier.id: "ID number"}


REMARKS = "Remarques"


def build_moodle_table(gradebook: Gradebook, identifier: MoodleIdentifier) -> MoodleTable:
    """Return the final marks; an empty cell leaves Moodle's mark as it is, and a last column says its state in words.

    Tests that are not released are left out, as Moodle would show them, and so are columns that are not published;
    students without an identifier of their own are too.
    """
    titles = distinct_assignment_titles(gradebook.assignments)
    shown = [n for n, assignment in enumerate(gradebook.assignments) if not is_test_withheld(assignment, gradebook.at)]
    published = [n for n, column in enumerate(gradebook.columns) if column.is_published]
    items = _number_duplicate_titles(
        [*(titles[n] for n in shown), *(gradebook.columns[n].full_title for n in published)]
    )
    uses = Counter(_moodle_identity(row.member, identifier) for row in gradebook.rows)
    rows: list[tuple[Cell, ...]] = []
    left_out = []
    for row in gradebook.rows:
        identity = _moodle_identity(row.member, identifier)
        if not identity or uses[identity] > 1 or escape_formula(identity) != identity:
            left_out.append(row.member.name)
            continue
        marks, columns = [row.marks[n] for n in shown], [row.columns[n] for n in published]
        points = (*map(_final_points_or_none, marks), *(mark.typed.points for mark in columns))
        states = [*(mark.state for mark in marks), *(mark.state for mark in columns)]
        remarks = [f"{title} : {french_state_words(state)}" for title, state in zip(items, states, strict=True)
                   if state in {*UNMARKED_STATES, MarkState.excused}]  # fmt: skip
        rows.append((identity, *points, " ; ".join(remarks)))
    header = (COLUMNS[identifier], *items, REMARKS)
    if not any(row[-1] for row in rows):
        header, rows = header[:-1], [row[:-1] for row in rows]
    return MoodleTable(header, tuple(rows), tuple(left_out))


def _moodle_identity(student: StudentRecord, identifier: MoodleIdentifier) -> str:
    return student.email.strip().casefold() if identifier is MoodleIdentifier.email else student.login


def _final_points_or_none(mark: AssignmentMark) -> float | None:
    return round_or_none(mark.points) if mark.state is MarkState.done else None
