"""The inputs for assignments and exemptions, validated with messages in French for each field."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from datetime import datetime
from typing import Any
from uuid import UUID

from server.assignments.models import (
    GROUP_LENGTH,
    TITLE_LENGTH,
    AttemptSelection,
    LatePolicy,
    Mode,
    Visibility,
    WeightedExercise,
)
from server.assignments.rules import MAX_POINTS
from server.assignments.team_rules import MAX_TEAM_SIZE
from server.base.errors import InvalidFields
from server.text.lines import describe_forbidden_character, normalise_line

MAX_WEIGHT = 1000.0
MAX_MINUTES = 7 * 24 * 60
TIME_FACTORS = (1.0, 4.0)
MIN_POINTS_PER_DAY = 0.01
REASON_LENGTH = 2000
ALLOWED_YEARS = range(2000, 2200)
NO_MEMBER = "Personne n’est dans le groupe « {label} »."

Problem = tuple[str, str]


@dataclass(frozen=True)
class AssignmentInput:
    """The fields of an assignment that a teacher sets; see `models.Assignment`."""

    title: str
    exercises: tuple[WeightedExercise, ...]
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
    groups: tuple[str, ...] = ()
    team_size: int = 1
    teams_by_students: bool = False

    def row_columns(self) -> dict[str, Any]:
        """Return the columns of the assignment's row: all fields but the exercises."""
        return {name: value for name, value in asdict(self).items() if name != "exercises"}


@dataclass(frozen=True)
class ExemptionInput:
    """The fields of an exemption that a teacher sets; None inherits."""

    opens_at: datetime | None = None
    due_at: datetime | None = None
    closes_at: datetime | None = None
    time_factor: float | None = None
    excused: bool | None = None
    reason: str = ""

    def row_columns(self) -> dict[str, Any]:
        return asdict(self)

    @property
    def changed_fields(self) -> dict[str, Any]:
        """The fields that change something, without the reason."""
        return {name: value for name, value in asdict(self).items() if name != "reason" and value is not None}


@dataclass(frozen=True)
class ExemptionTarget:
    """The students to exempt, or the label of all students to exempt."""

    students: tuple[UUID, ...] = ()
    label: str = ""


def validate_assignment(
    fields: AssignmentInput, exercises: Mapping[str, str], labels: Collection[str] = ()
) -> AssignmentInput:
    """Return the input with its title tidied. `exercises`: the titles of the exercises that may be assigned, by id;
    `labels`: the groups to which it may be given.

    Raises InvalidFields with every problem at once.
    """
    groups = tuple(dict.fromkeys(filter(None, map(normalise_line, fields.groups))))
    tidy = replace(fields, title=normalise_line(fields.title), groups=groups)
    if tidy.late is not LatePolicy.penalty:
        tidy = replace(tidy, late_per_day=None)
    if tidy.team_size == 1:
        tidy = replace(tidy, teams_by_students=False)
    _raise_if_problems(
        [
            *_check_fields(tidy),
            *_check_exercises(tidy.exercises, exercises),
            *_check_dates(tidy),
            *_check_groups(groups, labels),
        ]
    )
    return tidy


def validate_exemption(
    fields: ExemptionInput, opens_at: datetime, labels: Collection[str], target: ExemptionTarget
) -> None:
    """Check an exemption against the opening of its assignment and the labels of the class. Raises InvalidFields."""
    _raise_if_problems(
        [*_check_target(target, labels), *_check_effects(fields), *_check_order(fields.opens_at or opens_at, fields)]
    )


def _raise_if_problems(problems: list[Problem]) -> None:
    if problems:
        raise InvalidFields(dict(reversed(problems)))  # the first problem of a field wins


def _check_fields(fields: AssignmentInput) -> Iterator[Problem]:
    if not 0 < len(fields.title) <= TITLE_LENGTH:
        yield "title", f"Donnez au devoir un titre de 1 à {TITLE_LENGTH} caractères."
    if describe_forbidden_character(fields.title):
        yield "title", f"Dans le titre, {describe_forbidden_character(fields.title)}."
    if not _is_valid_weight(fields.weight):
        yield "weight", "Le coefficient du devoir est un nombre plus grand que 0, jusqu’à 1000."
    per_day = fields.late_per_day
    if fields.late is LatePolicy.penalty and (per_day is None or not MIN_POINTS_PER_DAY <= per_day <= MAX_POINTS):
        yield "late", "Indiquez combien de points sur 20 coûte chaque jour de retard : plus de 0, et 20 au plus."
    if fields.late is LatePolicy.penalty and fields.due_at is None:
        yield "due_at", "Une pénalité par jour de retard demande une date de remise."
    minutes = fields.duration_minutes
    if minutes is not None and not 1 <= minutes <= MAX_MINUTES:
        yield "duration_minutes", "La durée est un nombre de minutes, d’une à une semaine (10 080)."
    if minutes is not None and fields.mode is not Mode.test:
        yield "duration_minutes", "Seul un contrôle a une durée : choisissez ce mode, ou laissez la durée vide."
    if not 1 <= fields.team_size <= MAX_TEAM_SIZE:
        yield "team_size", f"Un devoir se rend seul, ou à {MAX_TEAM_SIZE} au plus."
    if fields.team_size > 1 and fields.mode is Mode.test:
        yield "team_size", "Un contrôle se compose seul : choisissez l’entraînement, ou « chacun seul »."


def _is_valid_weight(weight: float) -> bool:
    return math.isfinite(weight) and 0 < weight <= MAX_WEIGHT


def _check_exercises(chosen: Collection[WeightedExercise], titles: Mapping[str, str]) -> Iterator[Problem]:
    if not chosen:
        yield "exercises", "Choisissez au moins un exercice."
    seen = set()
    for exercise, weight in chosen:
        title = titles.get(exercise)
        if title is None:
            yield "exercises", f"L’exercice « {exercise[:100]} » n’est pas du module de la classe."
        elif exercise in seen:
            yield "exercises", f"L’exercice « {title} » est donné deux fois."
        elif not _is_valid_weight(weight):
            yield "exercises", f"Le coefficient de « {title} » est un nombre plus grand que 0, jusqu’à 1000."
        seen.add(exercise)


def _check_groups(groups: Collection[str], labels: Collection[str]) -> Iterator[Problem]:
    for label in groups:
        if label not in labels:
            yield "groups", NO_MEMBER.format(label=label[:GROUP_LENGTH])


def _check_dates(fields: AssignmentInput) -> Iterator[Problem]:
    opens, due, closes = fields.opens_at, fields.due_at, fields.closes_at
    yield from _check_years({"opens_at": opens, "due_at": due, "closes_at": closes})
    if due is not None and due < opens:
        yield "due_at", "La date de remise vient avant l’ouverture."
    if closes is not None and closes < (due or opens):
        yield "closes_at", f"La fermeture vient avant {'la date de remise' if due else 'l’ouverture'}."


def _check_years(dates: Mapping[str, datetime | None]) -> Iterator[Problem]:
    for name, when in dates.items():
        if when is not None and when.year not in ALLOWED_YEARS:
            yield name, "L’année doit être entre 2000 et 2199."


def _check_target(target: ExemptionTarget, labels: Collection[str]) -> Iterator[Problem]:
    if bool(target.students) == bool(target.label):
        yield "student", "Choisissez des élèves, ou un groupe."
    elif target.label and target.label not in labels:
        yield "group", NO_MEMBER.format(label=target.label[:GROUP_LENGTH])


def _check_effects(fields: ExemptionInput) -> Iterator[Problem]:
    if not fields.changed_fields:
        yield "due_at", "Dites ce qui change : une date, le temps, ou une dispense."
    low, high = TIME_FACTORS
    if fields.time_factor is not None and not low <= fields.time_factor <= high:
        yield "time_factor", "Le temps se multiplie par 1 à 4 : par 1,33 pour un tiers-temps."
    if len(fields.reason) > REASON_LENGTH:
        yield "reason", f"La raison tient en une ligne de {REASON_LENGTH} caractères."
    if describe_forbidden_character(fields.reason):
        yield "reason", f"Dans la raison, {describe_forbidden_character(fields.reason)}."
    yield from _check_years({"opens_at": fields.opens_at, "due_at": fields.due_at, "closes_at": fields.closes_at})


def _check_order(opens: datetime, fields: ExemptionInput) -> Iterator[Problem]:
    if fields.due_at is not None and fields.due_at < opens:
        yield "due_at", "La date de remise vient avant l’ouverture."
    if fields.closes_at is not None and fields.closes_at < (fields.due_at or opens):
        yield "closes_at", f"La fermeture vient avant {'la date de remise' if fields.due_at else 'l’ouverture'}."
