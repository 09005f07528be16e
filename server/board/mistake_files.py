"""The mistakes of a class by student, and its objectives, as tables to download."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from server.board.attempts import find_misconception_episodes
from server.board.catalogue import find_misconception
from server.board.objective_loading import ClassObjectives
from server.board.objectives import RULE, Mastery, MisconceptionLookup
from server.classes.schemas import StudentRecord
from server.gradebook.histories import Attempts
from server.marks.cells import Cell, WorkbookSheet
from server.marks.files import PERSON, person_cells

FormatTime = Callable[[datetime], str]
MISTAKE_HEADER = (*PERSON, "Exercice", "Erreur", "Objectif", "État", "Essais", "Première fois", "Dernière fois")
STATE_WORDS = {
    Mastery.mastered: "acquis", Mastery.started: "en cours", Mastery.weak: "à retravailler", Mastery.none: "",
}  # fmt: skip


def build_mistake_workbook(
    loaded: ClassObjectives, students: Sequence[StudentRecord], format_time: FormatTime
) -> tuple[WorkbookSheet, ...]:
    """Return the tables of mistakes and of objectives, then the rule of the latter."""
    rule = WorkbookSheet("Explications", ("Explication",), [(RULE,), (f"État du {format_time(loaded.progress.now)}.",)])
    return build_mistakes_sheet(loaded, students, format_time), build_objectives_sheet(loaded, students), rule


def build_mistakes_sheet(
    loaded: ClassObjectives, students: Sequence[StudentRecord], format_time: FormatTime
) -> WorkbookSheet:
    """Return a line for each student, exercise and misconception that some attempt shows."""
    rows = [row for student in students for row in _mistake_rows_of_student(loaded, student, format_time)]
    return WorkbookSheet("Erreurs", MISTAKE_HEADER, rows, frozen=2)


def _mistake_rows_of_student(
    loaded: ClassObjectives, student: StudentRecord, format_time: FormatTime
) -> list[tuple[Cell, ...]]:
    course, lookup = loaded.progress.course, MisconceptionLookup(loaded.progress.course)
    rows: list[tuple[Cell, ...]] = []
    for exercise, series in loaded.attempts_by_student.get(student.id, {}).items():
        times = _attempt_times_by_misconception(series)
        for mistake, episode in find_misconception_episodes(series):
            own = [
                p.objective
                for p in loaded.practised_objectives
                if lookup.belongs_to_objective(p.objective, exercise, mistake)
            ]
            rows.append(
                (
                    *person_cells(student),
                    course.title_of_exercise(exercise),
                    find_misconception(course, exercise, mistake).diagnosis.title,
                    " ; ".join(objective.short for objective in own),
                    "encore" if episode.attempts is None else "corrigée",
                    float(len(times[mistake])),
                    format_time(times[mistake][0]),
                    format_time(times[mistake][-1]),
                )
            )
    return rows


def _attempt_times_by_misconception(attempts: Attempts) -> Mapping[str, Sequence[datetime]]:
    times: dict[str, list[datetime]] = defaultdict(list)
    for attempt in attempts:
        if attempt.diagnosis is not None:
            times[attempt.diagnosis].append(attempt.sent_at)
    return times


def build_objectives_sheet(loaded: ClassObjectives, students: Sequence[StudentRecord]) -> WorkbookSheet:
    """Return the table of students × objectives, their states in words; nothing for what is not begun."""
    header = (*PERSON, *(practised.objective.short for practised in loaded.practised_objectives))
    rows = [(*person_cells(student), *_mastery_words_of_student(loaded, student.id)) for student in students]
    return WorkbookSheet("Objectifs", header, rows, frozen=2)


def _mastery_words_of_student(loaded: ClassObjectives, student: UUID) -> tuple[Cell, ...]:
    return tuple(STATE_WORDS[found.state] for found in loaded.states_by_student.get(student, ()))
