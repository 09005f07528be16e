"""Load where the students of a class stand in its objectives, in the caller's transaction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback
from server.assignments.feedback import NO_HOLDS, FeedbackHolds
from server.assignments.service import load_counting_exercises
from server.board.objectives import (
    ClassObjective,
    MisconceptionLookup,
    ObjectiveState,
    PractisedObjective,
    find_objective_states,
    list_practised_objectives,
    summarise_class_objectives,
)
from server.board.progress import ClassProgress
from server.classes import repository as classes
from server.classes.models import SchoolClass, Status
from server.course import Course, Module
from server.gradebook.histories import (
    Attempts,
    cached_per_history,
    group_by_account,
    load_attempts_by_pair,
    load_revisions,
)


@dataclass(frozen=True)
class ModuleObjectives:
    """The objectives of a module in a class where these exercises count; equal ones are of the same texts."""

    course: Course
    module: str
    counted: tuple[str, ...]

    @cached_property
    def practised_objectives(self) -> tuple[PractisedObjective, ...]:
        module = self.course.modules.get(self.module)
        return () if module is None else list_practised_objectives(module, frozenset(self.counted))

    @cached_property
    def misconception_lookup(self) -> MisconceptionLookup:
        return MisconceptionLookup(self.course)

    def objectives_for_student(self, unconcerned: frozenset[str]) -> tuple[PractisedObjective, ...]:
        """Return the same objectives; exercises that are for other groups are not expected of a student."""
        module = self.course.modules.get(self.module)
        if module is None or not unconcerned:
            return self.practised_objectives
        own = list_practised_objectives(module, frozenset(self.counted) - unconcerned)
        expected = {_objective_key(practised): practised for practised in own}
        return tuple(expected.get(_objective_key(practised), practised) for practised in self.practised_objectives)


@dataclass(frozen=True, eq=False)
class ClassObjectives:
    """The objectives of a class and the states of its students, from their attempts."""

    progress: ClassProgress
    module: str

    @cached_property
    def module_objectives(self) -> ModuleObjectives:
        return ModuleObjectives(self.progress.course, self.module, self.progress.scope.exercises)

    @property
    def practised_objectives(self) -> tuple[PractisedObjective, ...]:
        return self.module_objectives.practised_objectives

    @property
    def attempts_by_student(self) -> Mapping[UUID, Mapping[str, Attempts]]:
        return group_by_account(self.progress.attempts)

    @cached_property
    def states_by_student(self) -> Mapping[UUID, tuple[ObjectiveState, ...]]:
        """The states of each student, in the order of the list."""
        progress, attempts = self.progress, self.attempts_by_student
        place = progress.scope.class_id, self.module
        return {
            student.id: _find_student_states(
                attempts.get(student.id, {}),
                place,
                self.module_objectives,
                progress.find_exercises_of_other_groups(student),
            )
            for student in progress.students
        }

    def summarise_objectives(self, week_ends: Sequence[datetime]) -> tuple[ClassObjective, ...]:
        return summarise_class_objectives(self.practised_objectives, self.states_by_student, week_ends)


@cached_per_history
def _find_student_states(
    own: Mapping[str, Attempts],
    place: tuple[UUID, str],
    practice: ModuleObjectives,
    unconcerned: frozenset[str],
) -> tuple[ObjectiveState, ...]:
    return find_objective_states(practice.objectives_for_student(unconcerned), own, practice.misconception_lookup)


def _objective_key(practised: PractisedObjective) -> tuple[str, str]:
    return practised.objective.lesson, practised.objective.id


def load_student_objective_states(
    db: Session,
    course: Course,
    school_class: SchoolClass,
    student: UUID,
    now: datetime,
    until: datetime | None,
    *,
    as_student: bool,
) -> tuple[ObjectiveState, ...]:
    """Return the states of one student, of the attempts sent by `until`.

    `as_student`: of what they may know: without the attempts that a test holds, and the diagnoses that are held.
    """
    module = course.modules.get(school_class.module)
    if module is None:
        return ()
    membership = classes.find_membership(db, school_class.id, student)
    counted = load_counting_exercises(db, course, school_class, now).counting_for_student(
        membership.groups if membership else ()
    )
    attempts = load_attempts_by_pair(db, load_revisions(db, [student]), counted, until)
    own = group_by_account(attempts).get(student, {})
    if as_student:
        own = remove_withheld_feedback(own, feedback.load_holds_by_exercise(db, student))
    return find_objective_states(
        list_practised_objectives(module, frozenset(counted)), own, MisconceptionLookup(course)
    )


def load_own_objective_states(
    db: Session, course: Course, module: Module, account_id: UUID, now: datetime
) -> tuple[ObjectiveState, ...]:
    """Return the states that an account may know of itself: in its class of the module, or of all exercises of it."""
    for joined in classes.load_joined_classes(db, account_id):
        school_class, membership = joined.school_class, joined.membership
        is_student = membership.status is Status.active and not membership.is_staff
        if is_student and school_class.module == module.slug and school_class.archived_at is None:
            return load_student_objective_states(db, course, school_class, account_id, now, None, as_student=True)
    counted = [exercise.id for exercise in module.exercises]
    own = group_by_account(load_attempts_by_pair(db, load_revisions(db, [account_id]), counted, None)).get(
        account_id, {}
    )
    own = remove_withheld_feedback(own, feedback.load_holds_by_exercise(db, account_id))
    return find_objective_states(
        list_practised_objectives(module, frozenset(counted)), own, MisconceptionLookup(course)
    )


def remove_withheld_feedback(own: Mapping[str, Attempts], holds: Mapping[str, FeedbackHolds]) -> Mapping[str, Attempts]:
    """Return the attempts without what is held back from their author. Pure."""
    shown: dict[str, Attempts] = {}
    for exercise, series in own.items():
        hold = holds.get(exercise, NO_HOLDS)
        visible = [attempt for attempt in series if hold.find_withholding_test(attempt.sent_at) is None]
        if hold.diagnosis is not None:
            visible = [replace(attempt, diagnosis=None) for attempt in visible]
        if visible:
            shown[exercise] = visible
    return shown
