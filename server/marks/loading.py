"""Load the gradebook of a class: first its inputs, which are small and have a version, then the marks they give."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cached_property
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.class_assignments import ClassAssignments, load_class_assignments
from server.assignments.models import Assignment, AttemptSelection, LatePolicy, Mode, WeightedExercise
from server.assignments.rules import rules_in_force
from server.classes import repository as classes
from server.classes.models import SchoolClass
from server.classes.schemas import StudentRecord
from server.course import Course
from server.gradebook.histories import Revisions, load_attempts_by_pair, load_revisions
from server.marks import columns_repository, repository
from server.marks.marking import AssignmentMarker, TeacherChoices, mark_exercise
from server.marks.schemas import (
    NEVER_TYPED,
    ActiveDecision,
    ActiveOverride,
    ColumnMark,
    ColumnRecord,
    ExerciseMark,
    Gradebook,
    OverrideKey,
    StudentMarks,
    TypedMark,
)
from server.marks.states import ClassMarking

ALL_TITLE = "Exercices du module"
ALWAYS = datetime(2000, 1, 1, tzinfo=UTC)


@dataclass(frozen=True, eq=False)
class GradebookInputs:
    """Everything that a gradebook is computed from, but the attempts, of which it holds the version tags."""

    course: Course
    school_class: SchoolClass
    now: datetime
    students: Sequence[StudentRecord]
    assigned: ClassAssignments
    overrides: Mapping[OverrideKey, ActiveOverride]
    decisions: Mapping[tuple[UUID, UUID], ActiveDecision]
    marking: ClassMarking
    columns: Sequence[ColumnRecord]
    typed: Mapping[tuple[UUID, UUID], TypedMark]
    revisions: Revisions

    @cached_property
    def assignment_markers(self) -> Sequence[AssignmentMarker]:
        return [
            AssignmentMarker.build_for_assignment(assignment, self.assigned, self.students)
            for assignment in self.assigned.assignments
        ]

    @cached_property
    def version(self) -> Hashable:
        """The version of the class: equal versions mean equal marks."""
        return (
            self.course,
            self.school_class.id,
            self.school_class.archived_at,
            tuple(self.students),
            self.assigned.version,
            frozenset(self.overrides.items()),
            frozenset(self.decisions.items()),
            self.marking,
            tuple(self.columns),
            frozenset(self.typed.items()),
            frozenset(self.revisions.items()),
            self._past_instant_counts,
        )

    @property
    def _past_instant_counts(self) -> tuple[int, int]:
        """How many of the instants at which marks change by themselves are over, and how many of them begin now."""
        instants = {
            instant
            for marker in self.assignment_markers
            for instant in marker.iter_change_instants()
            if instant is not None
        }
        ordered = sorted(instants)
        return bisect_left(ordered, self.now), bisect_right(ordered, self.now)


def load_gradebook(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, only: Collection[UUID] | None = None
) -> Gradebook:
    """Load the marks of a class's active students, or of some of them; staff and former members have none."""
    return build_gradebook(db, load_inputs(db, course, school_class, now, only))


def load_inputs(
    db: Session, course: Course, school_class: SchoolClass, now: datetime, only: Collection[UUID] | None = None
) -> GradebookInputs:
    """Load the inputs in eight queries, one more for tests, and for teams, whatever the class."""
    students = classes.load_student_records(db, school_class.id, only)
    assigned = load_class_assignments(db, school_class.id, only)
    columns, typed = columns_repository.load_columns_and_marks(db, school_class.id, only)
    senders = {*(student.id for student in students), *assigned.find_partners([student.id for student in students])}
    return GradebookInputs(
        course=course,
        school_class=school_class,
        now=now,
        students=students,
        assigned=assigned if assigned.assignments else _module_as_single_assignment(course, school_class),
        overrides=repository.load_active_overrides(db, school_class.id, only),
        decisions=repository.load_active_decisions(db, school_class.id, only),
        marking=repository.load_marking_rules(db, school_class.id),
        columns=columns,
        typed=typed,
        revisions=load_revisions(db, senders),
    )


def build_gradebook(db: Session, inputs: GradebookInputs) -> Gradebook:
    """Compute the marks, in the transaction that loaded the inputs."""
    course, assigned = inputs.course, inputs.assigned
    exercises = {row.exercise for rows in assigned.exercises.values() for row in rows}
    attempts = load_attempts_by_pair(db, inputs.revisions, exercises, inputs.school_class.archived_at)
    weights = tuple(assignment.weight for assignment in assigned.assignments)
    marking = inputs.marking.rules
    choices = TeacherChoices(inputs.overrides, inputs.decisions, marking)
    rows = (
        StudentMarks(
            student,
            tuple(
                marker.mark_student(student.id, attempts.by_account, choices, inputs.now)
                for marker in inputs.assignment_markers
            ),
            weights,
            tuple(
                ColumnMark(column, inputs.typed.get((column.id, student.id), NEVER_TYPED), marking)
                for column in inputs.columns
            ),
        )
        for student in inputs.students
    )
    return Gradebook(
        school_class=inputs.school_class,
        at=inputs.now,
        assignments=tuple(assigned.assignments),
        rows=tuple(rows),
        titles={name: course.exercises[name].title for name in exercises if name in course.exercises},
        exercises={
            assignment.id: tuple(assigned.exercises.get(assignment.id, ())) for assignment in assigned.assignments
        },
        columns=tuple(inputs.columns),
        marking=marking,
    )


def _module_as_single_assignment(course: Course, school_class: SchoolClass) -> ClassAssignments:
    """Return the exercises of the module as one assignment without dates, for a class without assignments."""
    module = course.modules.get(school_class.module)
    names = [] if module is None else [exercise.id for exercise in module.exercises]
    whole_module = _undated_assignment(school_class)
    return ClassAssignments([whole_module], {whole_module.id: [WeightedExercise(name, 1.0) for name in names]}, {}, {})


def _undated_assignment(school_class: SchoolClass) -> Assignment:
    return Assignment(
        id=school_class.id,
        class_id=school_class.id,
        title=ALL_TITLE,
        mode=Mode.practice,
        opens_at=ALWAYS,
        team_size=1,
        late=LatePolicy.accept,
        counts=AttemptSelection.best,
        weight=1.0,
    )


def load_unassigned_mark(db: Session, school_class: SchoolClass, student: UUID, exercise: str) -> ExerciseMark:
    """Load a student's mark at an exercise that no assignment of the class asks: the best of all attempts."""
    attempts = load_attempts_by_pair(db, load_revisions(db, [student]), [exercise], school_class.archived_at)
    override = repository.load_active_overrides(db, school_class.id, [student], [exercise]).get(
        (student, exercise, None)
    )
    rules = rules_in_force(_undated_assignment(school_class), (), student, ())
    return mark_exercise(exercise, 1.0, attempts.get((student, exercise), ()), rules, AttemptSelection.best, override)
