"""The forms of assignments and exemptions: their text read, each fault at its field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import datetime
from enum import StrEnum
from typing import TypeVar
from uuid import UUID

from starlette.datastructures import FormData

from server.assignments.models import AttemptSelection, LatePolicy, Mode, Visibility, WeightedExercise
from server.assignments.schemas import AssignmentInput, ExemptionInput, ExemptionTarget
from server.base.errors import Invalid, InvalidFields
from server.database import utc_now
from server.desk.assignments.schemas import AssignmentValues, ExemptionValues
from server.desk.assignments.words import number
from server.web import school_time

NO_NUMBER = "{what} : « {text} » n’est pas un nombre."
NO_CHOICE = "Ce choix n’est pas proposé."
WEIGHT = "poids:"
LONGEST = 5000

Word = TypeVar("Word", bound=StrEnum)
T = TypeVar("T")


class _Reader:
    """Reads fields one after another, and keeps what is wrong with each."""

    def __init__(self, fields: FormData) -> None:
        self.fields = fields
        self.problems: dict[str, str] = {}

    def text(self, name: str) -> str:
        return text_of(self.fields, name)

    def _try(self, field: str, reading: Callable[[], T], instead: T) -> T:
        try:
            return reading()
        except Invalid as refused:
            self.problems.setdefault(field, refused.detail)
            return instead

    def date(self, name: str, field: str, what: str, kept: datetime | None) -> datetime | None:
        return self._try(field, lambda: school_time.parse_field(self.text(name), what, kept), None)

    def number(self, name: str, field: str, what: str) -> float | None:
        return self._try(field, lambda: _number(self.text(name), what), None)

    def word(self, name: str, field: str, of: type[Word], default: Word) -> Word:
        given = self.text(name) or default.value
        if given not in set(of):
            self.problems.setdefault(field, NO_CHOICE)
            return default
        return of(given)

    def refuse(self) -> None:
        """Raises InvalidFields where something is wrong."""
        if self.problems:
            raise InvalidFields(self.problems)


def text_of(fields: FormData, name: str) -> str:
    """Of a field that may be absent, or a file."""
    given = fields.get(name, "")
    return given.strip()[:LONGEST] if isinstance(given, str) else ""


def _number(text: str, what: str) -> float | None:
    """With a comma or a point. Raises Invalid."""
    plain = text.replace(",", ".").replace("\u202f", "").replace(" ", "")
    if not plain:
        return None
    digits = plain.replace(".", "", 1).removeprefix("-")
    if not (digits.isascii() and digits.isdigit()) or len(plain) > 20:
        raise Invalid(NO_NUMBER.format(what=what, text=text[:40]))
    return float(plain)


def assignment(fields: FormData, before: AssignmentInput | None) -> AssignmentInput:
    """What the form asks for; `before` is what the assignment is, which says to the second what its fields show.

    Raises InvalidFields.
    """
    read = _Reader(fields)
    opens = read.date("ouvre", "opens_at", "Ouverture", before.opens_at if before else None)
    due = read.date("rendre", "due_at", "À rendre avant", before.due_at if before else None)
    closes = read.date("ferme", "closes_at", "Fermeture", before.closes_at if before else None)
    weight = read.number("coefficient", "weight", "Coefficient")
    per_day = read.number("par_jour", "late", "Pénalité")
    minutes = read.number("duree", "duration_minutes", "Durée")
    if minutes is not None and minutes != int(minutes):
        read.problems.setdefault("duration_minutes", "La durée est un nombre entier de minutes.")
    exercises = tuple(
        WeightedExercise(name, _or_one(read.number(f"{WEIGHT}{name}", "exercises", f"Coefficient de « {name[:100]} »")))
        for name in chosen(fields)
    )
    wanted = AssignmentInput(
        title=read.text("titre"),
        exercises=exercises,
        opens_at=opens or utc_now().replace(second=0, microsecond=0),
        due_at=due,
        closes_at=closes,
        late=read.word("retard", "late", LatePolicy, LatePolicy.accept),
        late_per_day=per_day,
        counts=read.word("compte", "counts", AttemptSelection, AttemptSelection.best),
        weight=_or_one(weight),
        mode=read.word("mode", "mode", Mode, Mode.practice),
        hints=read.word("indices", "hints", Visibility, Visibility.usual),
        diagnosis=read.word("diagnostic", "diagnosis", Visibility, Visibility.usual),
        solution=read.word("corrige", "solution", Visibility, Visibility.usual),
        duration_minutes=None if minutes is None else int(minutes),
    )
    read.refuse()
    return wanted


def _or_one(given: float | None) -> float:
    return 1.0 if given is None else given


def chosen(fields: FormData) -> list[str]:
    """The exercises that are ticked."""
    return [name for name in fields.getlist("exercice") if isinstance(name, str)]


def assignment_values(fields: FormData) -> AssignmentValues:
    """The form as it was filled, to be shown again."""
    ticked = {name: text_of(fields, f"{WEIGHT}{name}") or "1" for name in chosen(fields) if len(name) <= 200}
    return AssignmentValues(
        title=text_of(fields, "titre"),
        opens=text_of(fields, "ouvre"),
        due=text_of(fields, "rendre"),
        closes=text_of(fields, "ferme"),
        late=text_of(fields, "retard") or LatePolicy.accept,
        per_day=text_of(fields, "par_jour"),
        weight=text_of(fields, "coefficient") or "1",
        counts=text_of(fields, "compte") or AttemptSelection.best,
        hints=text_of(fields, "indices") or Visibility.usual,
        diagnosis=text_of(fields, "diagnostic") or Visibility.usual,
        solution=text_of(fields, "corrige") or Visibility.usual,
        mode=text_of(fields, "mode") or Mode.practice,
        duration=text_of(fields, "duree"),
        weights=ticked,
    )


def values_of(wanted: AssignmentInput) -> AssignmentValues:
    """An assignment as its form shows it."""
    return AssignmentValues(
        title=wanted.title,
        opens=school_time.format_field(wanted.opens_at),
        due=school_time.format_field(wanted.due_at),
        closes=school_time.format_field(wanted.closes_at),
        late=wanted.late,
        per_day="" if wanted.late_per_day is None else number(wanted.late_per_day),
        weight=number(wanted.weight),
        counts=wanted.counts,
        hints=wanted.hints,
        diagnosis=wanted.diagnosis,
        solution=wanted.solution,
        mode=wanted.mode,
        duration="" if wanted.duration_minutes is None else str(wanted.duration_minutes),
        weights={one.exercise: number(one.weight) for one in wanted.exercises},
    )


EXCUSED: Mapping[str, bool | None] = {"": None, "oui": True, "non": False}


def exemption(fields: FormData) -> tuple[ExemptionTarget, ExemptionInput]:
    """For whom, and what. Raises InvalidFields."""
    read = _Reader(fields)
    students = []
    for name in fields.getlist("eleve"):
        try:
            students.append(UUID(str(name)))
        except ValueError:
            read.problems["student"] = "Cette personne n’est pas un élève de la classe."
    excused = read.text("dispense")
    if excused not in EXCUSED:
        read.problems["excused"] = NO_CHOICE
    wanted = ExemptionInput(
        opens_at=read.date("ouvre", "opens_at", "Ouverture", None),
        due_at=read.date("rendre", "due_at", "À rendre avant", None),
        closes_at=read.date("ferme", "closes_at", "Fermeture", None),
        time_factor=read.number("temps", "time_factor", "Temps"),
        excused=EXCUSED.get(excused),
        reason=read.text("raison"),
    )
    read.refuse()
    return ExemptionTarget(tuple(students), read.text("groupe")), wanted


def exemption_values(fields: FormData) -> ExemptionValues:
    return ExemptionValues(
        students=tuple(str(name) for name in fields.getlist("eleve")),
        group=text_of(fields, "groupe"),
        opens=text_of(fields, "ouvre"),
        due=text_of(fields, "rendre"),
        closes=text_of(fields, "ferme"),
        factor=text_of(fields, "temps"),
        excused=text_of(fields, "dispense"),
        reason=text_of(fields, "raison"),
        replace=bool(text_of(fields, "remplacer")),
    )
