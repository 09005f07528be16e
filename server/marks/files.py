"""A class's marks as files: for a spreadsheet, for Moodle, for a program, for a form to paste a column into."""

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
WORDS = {MarkState.absent: ABSENT, MarkState.excused: EXCUSED}


class MoodleIdentifier(StrEnum):
    """By what Moodle knows who is who."""

    email = "email"
    id = "id"


def file_name(book: Gradebook, what: str, ending: str) -> str:
    """In plain letters: « balise-mpsi-2-notes-2026-11-22.csv »."""
    return f"balise-{ascii_slug(book.school_class.name, 'classe')}-{what}-{book.at:%Y-%m-%d}.{ending}"


def mark_cell(mark: AssignmentMark) -> Cell:
    """Points, « Abs », « disp. », or nothing."""
    if mark.state in WORDS:
        return WORDS[mark.state]
    return _rounded(mark.points)


def unique_titles(assignments: Sequence[Assignment]) -> tuple[str, ...]:
    """Each once, so that columns can be told apart."""
    seen: Counter[str] = Counter()
    found = []
    for one in assignments:
        seen[one.title] += 1
        found.append(one.title if seen[one.title] == 1 else f"{one.title} ({seen[one.title]})")
    return tuple(found)


def _person(member: StudentRecord) -> tuple[str, str, str, str]:
    """Family name, given name, login, groups; who has no family name in the list is named whole."""
    listed = member.family_name
    family, given = (listed, member.given_name) if listed else (member.name, "")
    return family, given, member.login, ", ".join(member.groups)


PERSON = ("Nom", "Prénom", "Identifiant", "Groupe")


def marks_sheet(book: Gradebook) -> Sheet:
    """Students × assignments, with their averages."""
    rows = [
        (*_person(row.member), *(mark_cell(mark) for mark in row.marks), _rounded(row.average)) for row in book.rows
    ]
    return Sheet("Notes", (*PERSON, *unique_titles(book.assignments), AVERAGE), rows, frozen=2)


DETAILS = ("Points", "Note automatique", "Dispensé", "Jours de retard", "Essais", "Note modifiée", "À revoir", "Motif")


def exercises_sheet(book: Gradebook) -> Sheet:
    """A line for each student, assignment and exercise."""
    rows = [
        (*_person(row.member), title, book.title_of(one.exercise), *_details(one, mark))
        for row in book.rows
        for title, mark in zip(unique_titles(book.assignments), row.marks, strict=True)
        for one in mark.exercises
    ]
    return Sheet("Exercices", (*PERSON, "Devoir", "Exercice", *DETAILS), rows, frozen=2)


def _details(one: ExerciseMark, mark: AssignmentMark) -> tuple[Cell, ...]:
    excused = one.excused or mark.state is MarkState.excused
    return (
        None if excused else _rounded(one.points),
        _rounded(one.effective.automatic),
        YES[excused],
        float(one.days_late),
        float(one.attempts),
        YES[one.override is not None],
        YES[one.stale],
        one.override.reason if one.override else "",
    )


def explanations_sheet(book: Gradebook, when: FormatTime) -> Sheet:
    """What the other sheets hold, the weights and dates, the class's mean and median."""
    rows: list[tuple[Cell, ...]] = [
        (title, one.weight, when(one.opens_at), *(when(at) if at else "" for at in (one.due_at, one.closes_at)),
         "contrôle, pas encore rendu aux élèves" if is_withheld(one, book.at) else "", *_summed(book.summary_of(place)))
        for place, (title, one) in enumerate(zip(unique_titles(book.assignments), book.assignments, strict=True))
    ]  # fmt: skip
    rows.append((AVERAGE, None, "", "", "", "", *_summed(book.averages)))
    rows += [("",) + (None,) * 8] + [(note, *[None] * 8) for note in (*NOTES, f"Notes du {when(book.at)}.")]
    header = ("Devoir", "Coefficient", "Ouvre", "À rendre", "Ferme", "Remarque", "Copies", "Moyenne", "Médiane")
    return Sheet("Explications", header, rows, frozen=1)


def _summed(found: MarkSummary) -> tuple[Cell, ...]:
    return float(found.count), _rounded(found.mean), _rounded(found.median)


NOTES = (
    "Les notes sont sur 20, arrondies au centième ; les moyennes sont faites sur les points exacts.",
    f"« {ABSENT} » : le devoir est fini et rien n’a été envoyé ; il compte 0 dans la moyenne de l’élève.",
    f"« {EXCUSED} » : dispensé ; le devoir ou l’exercice ne compte pas dans la moyenne.",
    "Un devoir est fini quand plus rien ne peut être envoyé ; s’il ne ferme pas, quand sa date de rendu est passée.",
    "Fini, un exercice sans essai compte 0. En cours, seuls comptent les exercices envoyés, et le devoir n’entre pas "
    "encore dans la moyenne de l’élève. Un devoir sans date compte dès le premier envoi, sur ce qui est envoyé.",
    "La moyenne et la médiane de la classe sont celles des copies envoyées : ni absents, ni dispensés.",
)


def gradebook_sheets(book: Gradebook, when: FormatTime) -> tuple[Sheet, ...]:
    return marks_sheet(book), exercises_sheet(book), explanations_sheet(book, when)


def column_text(book: Gradebook, place: int | None) -> str:
    """One value a line, in the order of the list of names; None for the averages."""
    cells: list[Cell] = [_rounded(row.average) if place is None else mark_cell(row.marks[place]) for row in book.rows]
    return "\n".join("" if one is None else one if isinstance(one, str) else format_number(one) for one in cells)


@dataclass(frozen=True)
class MoodleFile:
    """The lines of a file that Moodle imports; the names of those who cannot be in it."""

    header: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    left_out: tuple[str, ...]

    def pieces(self) -> Iterator[bytes]:
        return plain_csv(self.header, self.rows)


COLUMNS = {MoodleIdentifier.email: "Email address", MoodleIdentifier.id: "ID number"}


def moodle_file(book: Gradebook, identifier: MoodleIdentifier) -> MoodleFile:
    """The marks that are final, and nothing for nothing: an empty cell leaves Moodle's mark as it is.

    A test that is held back is left out: Moodle would show it. Who has no identifier, or shares it, is left out too.
    """
    told = [place for place, one in enumerate(book.assignments) if not is_withheld(one, book.at)]
    known = Counter(_identity(row.member, identifier) for row in book.rows)
    rows, left_out = [], []
    for row in book.rows:
        identity = _identity(row.member, identifier)
        if not identity or known[identity] > 1 or escape_formula(identity) != identity:
            left_out.append(row.member.name)
        else:
            rows.append((identity, *(_final(row.marks[place]) for place in told)))
    named = unique_titles(book.assignments)
    return MoodleFile((COLUMNS[identifier], *(named[place] for place in told)), tuple(rows), tuple(left_out))


def _identity(member: StudentRecord, identifier: MoodleIdentifier) -> str:
    if identifier is MoodleIdentifier.email:
        return member.email.strip().casefold()
    return member.login


def _final(mark: AssignmentMark) -> float | None:
    found = mark_cell(mark)
    return None if isinstance(found, str) else found if mark.in_average is not None else None


def gradebook_json(book: Gradebook) -> dict[str, Any]:
    """The whole book, as plain values (contract, section 6)."""
    return {
        "class": {"id": book.school_class.id, "name": book.school_class.name, "module": book.school_class.module},
        "generated_at": book.at,
        "assignments": [_assignment(book, one, book.summary_of(place)) for place, one in enumerate(book.assignments)],
        "students": [
            {
                "id": row.member.id,
                "name": row.member.name,
                "groups": list(row.member.groups),
                "average": _rounded(row.average),
                "marks": [
                    _mark(assignment, mark) for assignment, mark in zip(book.assignments, row.marks, strict=True)
                ],
            }
            for row in book.rows
        ],
    }


def _assignment(book: Gradebook, one: Assignment, found: MarkSummary) -> dict[str, Any]:
    dates = {"opens_at": one.opens_at, "due_at": one.due_at, "closes_at": one.closes_at}
    exercises = [{"exercise": each.exercise, "weight": each.weight} for each in book.exercises[one.id]]
    sums = {"copies": found.count, "mean": _rounded(found.mean), "median": _rounded(found.median)}
    about = {"id": one.id, "title": one.title, "mode": Mode(one.mode), "weight": one.weight}
    return {**about, **dates, "held_back": is_withheld(one, book.at), "exercises": exercises, **sums}


def _mark(assignment: Assignment, mark: AssignmentMark) -> dict[str, Any]:
    return {
        "assignment": assignment.id,
        "state": mark.state,
        "points": _rounded(mark.points),
        "days_late": mark.days_late,
        "exercises": [exercise_mark_json(one) for one in mark.exercises],
    }


def exercise_mark_json(one: ExerciseMark) -> dict[str, Any]:
    override = one.override
    return {
        "exercise": one.exercise,
        "points": _rounded(one.points),
        "automatic": _rounded(one.effective.automatic),
        "excused": one.excused,
        "days_late": one.days_late,
        "attempts": one.attempts,
        "override": None
        if override is None
        else {
            "points": _rounded(override.points),
            "excused": override.excused,
            "reason": override.reason,
            "by": override.by or None,
            "at": override.at,
            "stale": one.stale,
        },
    }


def _rounded(points: float | None) -> float | None:
    return None if points is None else round_points(points)
