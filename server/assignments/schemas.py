"""What is asked of an assignment or an exemption, checked with sentences in French, each with its place."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from typing import Any
from uuid import UUID

from server.assignments.models import GROUP_LENGTH, TITLE_LENGTH, AttemptSelection, LatePolicy, Mode, Visibility
from server.assignments.rules import MAX_POINTS
from server.base.errors import InvalidFields

MOST_WEIGHT = 1000.0
LONGEST_MINUTES = 7 * 24 * 60
FACTORS = (1.0, 4.0)
LEAST_PER_DAY = 0.01  # what is read as a number of points
REASON_LENGTH = 2000
YEARS = range(2000, 2200)

Problem = tuple[str, str]


@dataclass(frozen=True)
class Weighted:
    """An exercise by its id, and its weight among the others."""

    exercise: str
    weight: float = 1.0


@dataclass(frozen=True)
class AssignmentInput:
    """All that a teacher sets of an assignment; `models.Assignment` says what each means."""

    title: str
    exercises: tuple[Weighted, ...]
    opens_at: datetime
    due_at: datetime | None = None
    closes_at: datetime | None = None
    late: LatePolicy = LatePolicy.accept
    late_per_day: float | None = None
    counts: AttemptSelection = AttemptSelection.best
    weight: float = 1.0
    mode: Mode = Mode.practice
    hints: Visibility = Visibility.usual
    diagnosis: Visibility = Visibility.usual
    solution: Visibility = Visibility.usual
    duration_minutes: int | None = None

    def columns(self) -> dict[str, Any]:
        """As the row of the assignment holds it: all but the exercises."""
        return {name: value for name, value in asdict(self).items() if name != "exercises"}


@dataclass(frozen=True)
class ExemptionInput:
    """What is to differ for some; None inherits."""

    opens_at: datetime | None = None
    due_at: datetime | None = None
    closes_at: datetime | None = None
    time_factor: float | None = None
    excused: bool | None = None
    reason: str = ""

    def columns(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def effects(self) -> dict[str, Any]:
        """What it says, without why."""
        return {name: value for name, value in asdict(self).items() if name != "reason" and value is not None}


@dataclass(frozen=True)
class ExemptionTarget:
    """For whom an exemption is made: students, or all who have a label."""

    students: tuple[UUID, ...] = ()
    label: str = ""


def validate_assignment(wanted: AssignmentInput, exercises: Mapping[str, str]) -> AssignmentInput:
    """The same, its title tidied; `exercises` are those that one may give, by their titles.

    Raises FieldsRefused with all that is wrong at once.
    """
    tidy = replace(wanted, title=" ".join(wanted.title.split()))
    if tidy.late is not LatePolicy.penalty:
        tidy = replace(tidy, late_per_day=None)
    _refuse([*_about_itself(tidy), *_exercises(tidy.exercises, exercises), *_dates(tidy)])
    return tidy


def validate_exemption(
    wanted: ExemptionInput, opens_at: datetime, labels: Collection[str], whom: ExemptionTarget
) -> None:
    """`opens_at` is the assignment's; `labels` are those of the class. Raises FieldsRefused."""
    _refuse([*_whom(whom, labels), *_effects(wanted), *_order(wanted.opens_at or opens_at, wanted)])


def _refuse(problems: list[Problem]) -> None:
    if problems:
        raise InvalidFields(dict(reversed(problems)))  # of a field, the first is told


def _about_itself(wanted: AssignmentInput) -> Iterator[Problem]:
    if not 0 < len(wanted.title) <= TITLE_LENGTH or not wanted.title.isprintable():
        yield "title", f"Donnez au devoir un titre de 1 à {TITLE_LENGTH} caractères."
    if not _positive(wanted.weight):
        yield "weight", "Le coefficient du devoir est un nombre plus grand que 0, jusqu’à 1000."
    per_day = wanted.late_per_day
    if wanted.late is LatePolicy.penalty and (per_day is None or not LEAST_PER_DAY <= per_day <= MAX_POINTS):
        yield "late", "Indiquez combien de points sur 20 coûte chaque jour de retard : plus de 0, et 20 au plus."
    if wanted.late is LatePolicy.penalty and wanted.due_at is None:
        yield "due_at", "Une pénalité par jour de retard demande une date de remise."
    minutes = wanted.duration_minutes
    if minutes is not None and not 1 <= minutes <= LONGEST_MINUTES:
        yield "duration_minutes", "La durée est un nombre de minutes, d’une à une semaine (10 080)."
    if minutes is not None and wanted.mode is not Mode.test:
        yield "duration_minutes", "Seul un contrôle a une durée : choisissez ce mode, ou laissez la durée vide."


def _positive(weight: float) -> bool:
    return math.isfinite(weight) and 0 < weight <= MOST_WEIGHT


def _exercises(chosen: Collection[Weighted], known: Mapping[str, str]) -> Iterator[Problem]:
    if not chosen:
        yield "exercises", "Choisissez au moins un exercice."
    seen = set()
    for one in chosen:
        name = known.get(one.exercise)
        if name is None:
            yield "exercises", f"L’exercice « {one.exercise[:100]} » n’est pas du module de la classe."
        elif one.exercise in seen:
            yield "exercises", f"L’exercice « {name} » est donné deux fois."
        elif not _positive(one.weight):
            yield "exercises", f"Le coefficient de « {name} » est un nombre plus grand que 0, jusqu’à 1000."
        seen.add(one.exercise)


def _dates(wanted: AssignmentInput) -> Iterator[Problem]:
    opens, due, closes = wanted.opens_at, wanted.due_at, wanted.closes_at
    yield from _years({"opens_at": opens, "due_at": due, "closes_at": closes})
    if due is not None and due < opens:
        yield "due_at", "La date de remise vient avant l’ouverture."
    if closes is not None and closes < (due or opens):
        yield "closes_at", f"La fermeture vient avant {'la date de remise' if due else 'l’ouverture'}."


def _years(dates: Mapping[str, datetime | None]) -> Iterator[Problem]:
    for name, when in dates.items():
        if when is not None and when.year not in YEARS:
            yield name, "L’année doit être entre 2000 et 2199."


def _whom(whom: ExemptionTarget, labels: Collection[str]) -> Iterator[Problem]:
    if bool(whom.students) == bool(whom.label):
        yield "student", "Choisissez des élèves, ou un groupe."
    elif whom.label and whom.label not in labels:
        yield "group", f"Personne n’est dans le groupe « {whom.label[:GROUP_LENGTH]} »."


def _effects(wanted: ExemptionInput) -> Iterator[Problem]:
    if not wanted.effects:
        yield "due_at", "Dites ce qui change : une date, le temps, ou une dispense."
    low, high = FACTORS
    if wanted.time_factor is not None and not low <= wanted.time_factor <= high:
        yield "time_factor", "Le temps se multiplie par 1 à 4 : par 1,33 pour un tiers-temps."
    if len(wanted.reason) > REASON_LENGTH or not wanted.reason.isprintable():
        yield "reason", f"La raison tient en une ligne de {REASON_LENGTH} caractères."
    yield from _years({"opens_at": wanted.opens_at, "due_at": wanted.due_at, "closes_at": wanted.closes_at})


def _order(opens: datetime, wanted: ExemptionInput) -> Iterator[Problem]:
    if wanted.due_at is not None and wanted.due_at < opens:
        yield "due_at", "La date de remise vient avant l’ouverture."
    if wanted.closes_at is not None and wanted.closes_at < (wanted.due_at or opens):
        yield "closes_at", f"La fermeture vient avant {'la date de remise' if wanted.due_at else 'l’ouverture'}."
