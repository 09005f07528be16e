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
from server.base import school_time
from server.base.errors import Invalid, InvalidFields
from server.database import utc_now
from server.desk.assignments import words
from server.desk.assignments.exemption_schemas import ExemptionValues
from server.desk.assignments.schemas import AssignmentValues
from server.desk.assignments.words import format_number
from server.text.lines import normalise_line

NO_NUMBER = "{what} : « {text} » n’est pas un nombre."
NO_CHOICE = "Ce choix n’est pas proposé."
NO_GROUP = "Cochez au moins un groupe, ou donnez le devoir à toute la classe."
WEIGHT_PREFIX = "poids:"
MAX_FIELD_CHARACTERS = 5000

ChoiceEnum = TypeVar("ChoiceEnum", bound=StrEnum)
T = TypeVar("T")


class _FormReader:
    """Reads fields one after another, and keeps what is wrong with each."""

    def __init__(self, fields: FormData) -> None:
        self.fields = fields
        self.problems: dict[str, str] = {}

    def text(self, name: str) -> str:
        return field_text(self.fields, name)

    def _read_or_record(self, field: str, reading: Callable[[], T], instead: T) -> T:
        try:
            return reading()
        except Invalid as refused:
            self.problems.setdefault(field, refused.detail)
            return instead

    def date(self, name: str, field: str, what: str, kept: datetime | None) -> datetime | None:
        return self._read_or_record(field, lambda: school_time.parse_field(self.text(name), what, kept), None)

    def number(self, name: str, field: str, what: str) -> float | None:
        return self._read_or_record(field, lambda: _parse_number(self.text(name), what), None)

    def choice(self, name: str, field: str, of: type[ChoiceEnum], default: ChoiceEnum) -> ChoiceEnum:
        given = self.text(name) or default.value
        if given not in set(of):
            self.problems.setdefault(field, NO_CHOICE)
            return default
        return of(given)

    def raise_problems(self) -> None:
        """Raises InvalidFields where something is wrong."""
        if self.problems:
            raise InvalidFields(self.problems)


def field_text(fields: FormData, name: str) -> str:
    """Of a field that may be absent, or a file."""
    given = fields.get(name, "")
    return normalise_line(given[:MAX_FIELD_CHARACTERS]) if isinstance(given, str) else ""


def _parse_number(text: str, what: str) -> float | None:
    """With a comma or a point. Raises Invalid."""
    plain = text.replace(",", ".").replace("\u202f", "").replace(" ", "")
    if not plain:
        return None
    digits = plain.replace(".", "", 1).removeprefix("-")
    if not (digits.isascii() and digits.isdigit()) or len(plain) > 20:
        raise Invalid(NO_NUMBER.format(what=what, text=text[:40]))
    return float(plain)


def parse_assignment(fields: FormData, before: AssignmentInput | None) -> AssignmentInput:
    """What the form asks for; `before` is what the assignment is, which says to the second what its fields show.

    Raises InvalidFields.
    """
    read = _FormReader(fields)
    opens = read.date("ouvre", "opens_at", "Ouverture", before.opens_at if before else None)
    due = read.date("rendre", "due_at", "Date limite", before.due_at if before else None)
    closes = read.date("ferme", "closes_at", "Fermeture", before.closes_at if before else None)
    weight = read.number("coefficient", "weight", "Coefficient")
    per_day = read.number("par_jour", "late", "Pénalité")
    team_size = read.number("rendu_a", "team_size", "Nombre d’élèves par copie")
    minutes = read.number("duree", "duration_minutes", "Durée")
    if minutes is not None and minutes != int(minutes):
        read.problems.setdefault("duration_minutes", "La durée est un nombre entier de minutes.")
    exercises = tuple(
        WeightedExercise(
            name,
            _default_weight(read.number(f"{WEIGHT_PREFIX}{name}", "exercises", f"Coefficient de « {name[:100]} »")),
        )
        for name in checked_exercises(fields)
    )
    wanted = AssignmentInput(
        title=read.text("titre"),
        exercises=exercises,
        opens_at=opens or utc_now().replace(second=0, microsecond=0),
        due_at=due,
        closes_at=closes,
        late=read.choice("retard", "late", LatePolicy, LatePolicy.accept),
        late_per_day=per_day,
        counts=read.choice("compte", "counts", AttemptSelection, AttemptSelection.best),
        weight=_default_weight(weight),
        mode=read.choice("mode", "mode", Mode, Mode.practice),
        hints=read.choice("indices", "hints", Visibility, Visibility.usual),
        diagnosis=read.choice("diagnostic", "diagnosis", Visibility, Visibility.usual),
        solution=read.choice("corrige", "solution", Visibility, Visibility.usual),
        duration_minutes=None if minutes is None else int(minutes),
        groups=checked_groups(fields),
        team_size=int(team_size or 1) if team_size is None or team_size == int(team_size) else 0,
        teams_by_students=bool(read.text("equipes_par_eleves")),
    )
    if field_text(fields, "donne_a") and not wanted.groups:
        read.problems["groups"] = NO_GROUP
    read.raise_problems()
    return wanted


def _default_weight(given: float | None) -> float:
    return 1.0 if given is None else given


def checked_exercises(fields: FormData) -> list[str]:
    """The exercises that are ticked."""
    return [name for name in fields.getlist("exercice") if isinstance(name, str)]


def checked_groups(fields: FormData) -> tuple[str, ...]:
    """The groups that are ticked, unless the assignment is for the whole class."""
    if field_text(fields, "donne_a") != "groupes":
        return ()
    return tuple(
        normalise_line(name[:MAX_FIELD_CHARACTERS]) for name in fields.getlist("groupe") if isinstance(name, str)
    )


def submitted_assignment_values(fields: FormData) -> AssignmentValues:
    """The form as it was filled, to be shown again."""
    ticked = {
        name: field_text(fields, f"{WEIGHT_PREFIX}{name}") or "1"
        for name in checked_exercises(fields)
        if len(name) <= 200
    }
    return AssignmentValues(
        title=field_text(fields, "titre"),
        opens=field_text(fields, "ouvre"),
        due=field_text(fields, "rendre"),
        closes=field_text(fields, "ferme"),
        late=field_text(fields, "retard") or LatePolicy.accept,
        per_day=field_text(fields, "par_jour"),
        weight=field_text(fields, "coefficient") or "1",
        counts=field_text(fields, "compte") or AttemptSelection.best,
        hints=field_text(fields, "indices") or Visibility.usual,
        diagnosis=field_text(fields, "diagnostic") or Visibility.usual,
        solution=field_text(fields, "corrige") or Visibility.usual,
        mode=field_text(fields, "mode") or Mode.practice,
        duration=field_text(fields, "duree"),
        weights=ticked,
        audience=field_text(fields, "donne_a"),
        groups=tuple(name[:MAX_FIELD_CHARACTERS] for name in fields.getlist("groupe") if isinstance(name, str)),
        team_size=field_text(fields, "rendu_a") or "1",
        teams_by_students=field_text(fields, "equipes_par_eleves"),
    )


def stored_assignment_values(wanted: AssignmentInput) -> AssignmentValues:
    """An assignment as its form shows it."""
    return AssignmentValues(
        title=wanted.title,
        opens=school_time.format_field(wanted.opens_at),
        due=school_time.format_field(wanted.due_at),
        closes=school_time.format_field(wanted.closes_at),
        late=wanted.late,
        per_day="" if wanted.late_per_day is None else format_number(wanted.late_per_day),
        weight=format_number(wanted.weight),
        counts=wanted.counts,
        hints=wanted.hints,
        diagnosis=wanted.diagnosis,
        solution=wanted.solution,
        mode=wanted.mode,
        duration="" if wanted.duration_minutes is None else str(wanted.duration_minutes),
        weights={exercise.exercise: format_number(exercise.weight) for exercise in wanted.exercises},
        audience="groupes" if wanted.groups else "",
        groups=tuple(wanted.groups),
        team_size=str(wanted.team_size),
        teams_by_students="oui" if wanted.teams_by_students else "",
    )


def assignment_texts(values: AssignmentValues) -> Mapping[str, str]:
    """Return the values of the form by their labels, to compare two versions."""
    exercises = (f"{name} (coefficient {weight})" for name, weight in sorted(values.weights.items()))
    return {
        "Titre": values.title,
        "Exercices": ", ".join(exercises),
        "Donné à": ", ".join(values.chosen_groups) or "toute la classe",
        "Ouverture": values.opens.replace("T", " "),
        "Date limite": values.due.replace("T", " "),
        "Fermeture": values.closes.replace("T", " "),
        "Retard": _choice_in_words(words.LATE_POLICY_WORDS, values.late),
        "Points perdus par jour": values.per_day,
        "Essai retenu": _choice_in_words(words.SELECTION_WORDS, values.counts),
        "Coefficient du devoir": values.weight,
        "Indices montrés": _choice_in_words(words.VISIBILITY_WORDS, values.hints),
        "Diagnostic montré": _choice_in_words(words.VISIBILITY_WORDS, values.diagnosis),
        "Corrigé montré": _choice_in_words(words.VISIBILITY_WORDS, values.solution),
        "Mode": _choice_in_words(words.MODE_WORDS, values.mode),
        "Rendu à": values.team_size,
        "Équipes formées par les élèves": values.teams_by_students or "non",
        "Durée, en minutes": values.duration,
    }


def _choice_in_words(texts: Mapping[ChoiceEnum, str], value: str) -> str:
    return next((text for choice, text in texts.items() if choice.value == value), value)


EXCUSED: Mapping[str, bool | None] = {"": None, "oui": True, "non": False}


def parse_exemption(fields: FormData) -> tuple[ExemptionTarget, ExemptionInput]:
    """For whom, and what. Raises InvalidFields."""
    read = _FormReader(fields)
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
        due_at=read.date("rendre", "due_at", "Date limite", None),
        closes_at=read.date("ferme", "closes_at", "Fermeture", None),
        time_factor=read.number("temps", "time_factor", "Temps"),
        excused=EXCUSED.get(excused),
        reason=read.text("raison"),
    )
    read.raise_problems()
    return ExemptionTarget(tuple(students), read.text("groupe")), wanted


def submitted_exemption_values(fields: FormData) -> ExemptionValues:
    return ExemptionValues(
        students=tuple(str(name) for name in fields.getlist("eleve")),
        group=field_text(fields, "groupe"),
        opens=field_text(fields, "ouvre"),
        due=field_text(fields, "rendre"),
        closes=field_text(fields, "ferme"),
        factor=field_text(fields, "temps"),
        excused=field_text(fields, "dispense"),
        reason=field_text(fields, "raison"),
        replace=bool(field_text(fields, "remplacer")),
    )
