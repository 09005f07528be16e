"""Where students stand in the objectives of their module: pure. `RULE` says these rules on the pages."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from enum import StrEnum
from uuid import UUID

from server.board.attempts import FAILURES, first_success_time
from server.board.catalogue import find_misconception
from server.board.stuck import trailing_failures_without_progress
from server.course import Course, Module
from server.course.objectives import Objective
from server.course.practice import practised_objectives
from server.gradebook.histories import Attempts

#: Exercises to solve for an objective, or all where it has fewer.
MIN_SOLVED = 2
#: Different failures: those that show a mistake of the objective, or those without a known mistake nor progress.
MIN_MISTAKEN, MIN_UNEXPLAINED = 2, 3
WEEK = timedelta(days=7)
RULE = (
    "Un objectif est « acquis » quand deux de ses exercices sont réussis (ou le seul qu’il ait, défis exclus) et "
    "qu’aucune de ses erreurs ne demeure. Il est « à retravailler » quand, dans un exercice non réussi, le dernier "
    "essai montre encore une de ses erreurs après deux essais différents, ou quand trois essais différents échouent "
    "sans progrès ni erreur identifiée. Il est « en cours » dès le premier essai."
)


class Mastery(StrEnum):
    """The state of a student in an objective."""

    none = "none"
    started = "started"
    weak = "weak"
    mastered = "mastered"


@dataclass(frozen=True)
class PractisedObjective:
    """An objective with the ids of its exercises that count in a class; `required` of them are to be solved.

    `related`: of others that count, those whose misconceptions may belong to it.
    """

    objective: Objective
    exercises: tuple[str, ...]
    related: tuple[str, ...]
    required: int


@dataclass(frozen=True)
class ObjectiveState:
    """A student in an objective. `solved`, `failing`: exercises; `mistakes`: (exercise, misconception) that remain.

    `mastered_at`: when the last required exercise was solved, whether or not a mistake came back.
    """

    objective: PractisedObjective
    state: Mastery
    solved: tuple[str, ...]
    failing: tuple[str, ...]
    mistakes: tuple[tuple[str, str], ...]
    mastered_at: datetime | None


def list_practised_objectives(module: Module, counted: Collection[str]) -> tuple[PractisedObjective, ...]:
    """Return the objectives of a module that some counting exercise practises, in reading order."""
    stars = {exercise.slug: exercise.stars for exercise in module.exercises if exercise.id in counted}
    practised = []
    for objective in practised_objectives(module):
        slugs = [slug for slug in objective.exercises if slug in stars]
        others = [slug for slug in objective.mistakes if slug in stars and slug not in slugs]
        plain = sum(not stars[slug] for slug in slugs)
        if slugs:
            ids = tuple(f"{module.slug}/{slug}" for slug in slugs)
            related = tuple(f"{module.slug}/{slug}" for slug in others)
            practised.append(PractisedObjective(objective, ids, related, max(1, min(MIN_SOLVED, plain))))
    return tuple(practised)


class MisconceptionLookup:
    """Tells whether a misconception of the course belongs to an objective; each is looked up once."""

    def __init__(self, course: Course) -> None:
        self._course = course
        self._functions: dict[tuple[str, str], tuple[str, ...]] = {}

    def belongs_to_objective(self, objective: Objective, exercise: str, misconception: str) -> bool:
        key = exercise, misconception
        if key not in self._functions:
            self._functions[key] = find_misconception(self._course, exercise, misconception).functions
        return objective.does_misconception_belong(exercise.partition("/")[2], misconception, self._functions[key])

    def misconception_title(self, exercise: str, misconception: str) -> str:
        """Return the title of a misconception."""
        return find_misconception(self._course, exercise, misconception).diagnosis.title


def find_objective_states(
    objectives: Sequence[PractisedObjective], own: Mapping[str, Attempts], lookup: MisconceptionLookup
) -> tuple[ObjectiveState, ...]:
    """Return the state of a student in each objective; `own`: their attempts by exercise."""
    solved_times = {exercise: at for exercise, series in own.items() if (at := first_success_time(series)) is not None}
    return tuple(_find_objective_state(practised, own, solved_times, lookup) for practised in objectives)


def _find_objective_state(
    practised: PractisedObjective,
    own: Mapping[str, Attempts],
    solved_times: Mapping[str, datetime],
    lookup: MisconceptionLookup,
) -> ObjectiveState:
    tried = [exercise for exercise in practised.exercises if own.get(exercise)]
    solved = [exercise for exercise in tried if exercise in solved_times]
    failing = [exercise for exercise in tried if exercise not in solved_times]
    mistakes, is_weak = [], False
    for exercise in (*failing, *(name for name in practised.related if own.get(name) and name not in solved_times)):
        series = own[exercise]
        latest = series[-1].diagnosis
        if latest is not None and lookup.belongs_to_objective(practised.objective, exercise, latest):
            mistakes.append((exercise, latest))
            is_weak |= _count_failures_with_mistake(practised.objective, exercise, series, lookup) >= MIN_MISTAKEN
        elif latest is None and exercise in failing:
            run = [attempt for attempt in trailing_failures_without_progress(series) if attempt.diagnosis is None]
            is_weak |= len({attempt.digest for attempt in run}) >= MIN_UNEXPLAINED
    times = sorted(solved_times[exercise] for exercise in solved)
    mastered_at = times[practised.required - 1] if len(times) >= practised.required else None
    if is_weak:
        state = Mastery.weak
    elif mastered_at is not None and not mistakes:
        state = Mastery.mastered
    else:
        state = Mastery.started if tried or mistakes else Mastery.none
    return ObjectiveState(practised, state, tuple(solved), tuple(failing), tuple(mistakes), mastered_at)


def _count_failures_with_mistake(
    objective: Objective, exercise: str, attempts: Attempts, lookup: MisconceptionLookup
) -> int:
    """Count the different failures of a series that show a mistake of an objective."""
    return len(
        {
            attempt.digest
            for attempt in attempts
            if attempt.outcome in FAILURES
            and attempt.diagnosis is not None
            and lookup.belongs_to_objective(objective, exercise, attempt.diagnosis)
        }
    )


@dataclass(frozen=True)
class ClassObjective:
    """An objective in a class: its students in each state, in the order of the list.

    `mistakes`: (exercise, misconception) with the number of students in whom it remains, the commonest first.
    `weekly`: how many had solved its required exercises at the end of each week, the latest last.
    """

    practised: PractisedObjective
    students: Mapping[Mastery, tuple[UUID, ...]]
    mistakes: tuple[tuple[tuple[str, str], int], ...]
    weekly: tuple[int, ...]

    def count_students(self, state: Mastery) -> int:
        return len(self.students[state])


def summarise_class_objectives(
    objectives: Sequence[PractisedObjective],
    states: Mapping[UUID, Sequence[ObjectiveState]],
    week_ends: Sequence[datetime],
) -> tuple[ClassObjective, ...]:
    """Put the states of the students of a class together; `states` are in the order of `objectives`."""
    rows = []
    for index, practised in enumerate(objectives):
        own = {account: of_student[index] for account, of_student in states.items()}
        remaining: dict[tuple[str, str], int] = {}
        for found in own.values():
            for mistake in found.mistakes:
                remaining[mistake] = remaining.get(mistake, 0) + 1
        times = [found.mastered_at for found in own.values() if found.mastered_at is not None]
        rows.append(
            ClassObjective(
                practised,
                {state: tuple(a for a, found in own.items() if found.state is state) for state in Mastery},
                tuple(sorted(remaining.items(), key=lambda pair: (-pair[1], pair[0]))),
                tuple(sum(at <= end for at in times) for end in week_ends),
            )
        )
    return tuple(rows)
