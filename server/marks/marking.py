"""Compute the marks of an assignment from what its students sent: pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from server.assignments.class_assignments import ClassAssignments
from server.assignments.counting import attempts_in_sitting, mark_attempts
from server.assignments.feedback import SittingStage, sitting_stage
from server.assignments.models import Assignment, AttemptSelection, Mode, Sitting, WeightedExercise
from server.assignments.rules import Rules, rules_in_force
from server.classes.schemas import StudentRecord
from server.gradebook.histories import Attempts, AttemptsByPair
from server.marks.schemas import ActiveOverride, AssignmentMark, ExerciseMark, MarkState, StudentExercise

ENDED_STAGES = frozenset((SittingStage.over, SittingStage.missed, SittingStage.shown))


@dataclass(frozen=True, eq=False)
class AssignmentMarker:
    """Marks one assignment of a class. `rules` are those in force, by student."""

    assignment: Assignment
    exercises: Sequence[WeightedExercise]
    sittings: Mapping[UUID, Sitting]
    rules: Mapping[UUID, Rules]

    @classmethod
    def for_assignment(
        cls, assignment: Assignment, assigned: ClassAssignments, students: Sequence[StudentRecord]
    ) -> AssignmentMarker:
        exemptions = assigned.exemptions.get(assignment.id, ())
        common = rules_in_force(assignment, (), assignment.class_id, ())
        rules = {
            student.id: rules_in_force(assignment, exemptions, student.id, student.groups) if exemptions else common
            for student in students
        }
        exercises = assigned.exercises.get(assignment.id, ())
        return cls(assignment, exercises, assigned.sittings.get(assignment.id, {}), rules)

    def instants(self) -> Iterator[datetime | None]:
        """Yield every time at which a mark may change by itself: all that `mark` and `is_withheld` compare with now."""
        yield self.assignment.released_at
        for student, rules in self.rules.items():
            yield from (rules.opens_at, rules.due_at, rules.closes_at)
            if sitting := self.sittings.get(student):
                yield rules.end_of_sitting(sitting.began_at)

    def mark(
        self,
        student: UUID,
        attempts: AttemptsByPair,
        overrides: Mapping[StudentExercise, ActiveOverride],
        now: datetime,
    ) -> AssignmentMark:
        """Return the mark of one student."""
        rules, sitting = self.rules[student], self.sittings.get(student)
        is_test, counts = self.assignment.mode == Mode.test, AttemptSelection(self.assignment.counts)
        marks = []
        for exercise, weight in self.exercises:
            pair = student, exercise
            sent: Attempts = attempts.get(pair, ())
            if is_test:
                sent = attempts_in_sitting(sent, sitting.began_at, sitting.handed_in_at) if sitting else ()
            marks.append(mark_exercise(exercise, weight, sent, rules, counts, overrides.get(pair)))
        # A test ends for a student who has handed in, whose time is over, or once its results are out.
        ended = is_test and sitting_stage(self.assignment, rules, sitting, now) in ENDED_STAGES
        state = mark_state(rules, marks, now, has_begun_test=sitting is not None, ended=ended)
        return AssignmentMark(rules, state, tuple(marks), ended)


def mark_exercise(
    exercise: str,
    weight: float,
    attempts: Attempts,
    rules: Rules,
    counts: AttemptSelection,
    override: ActiveOverride | None,
) -> ExerciseMark:
    """Return the mark of one student at one exercise, from the attempts and the override in force."""
    result = mark_attempts(rules, counts, attempts)
    counted_id = None if result.counted is None else result.counted.attempt
    counted = next((attempt for attempt in attempts if attempt.id == counted_id), None)
    return ExerciseMark(
        exercise=exercise,
        weight=weight,
        counted=result.counted,
        grading=None if counted is None else str(counted.grading_id),
        sent_at=None if counted is None else counted.sent_at,
        attempts=result.attempts,
        override=override,
    )


def mark_state(
    rules: Rules,
    marks: Sequence[ExerciseMark],
    now: datetime,
    *,
    has_begun_test: bool = False,
    ended: bool = False,
) -> MarkState:
    """Return the state of an assignment for a student. An override counts as something sent.

    A test is open to a student who has begun it, whatever its dates have become. `ended`: the student can send nothing
    more, whatever the dates.
    """
    if rules.excused or (marks and all(mark.excused for mark in marks)):
        return MarkState.excused
    begun = any(mark.points is not None for mark in marks)
    if ended:
        return MarkState.done if begun else MarkState.absent
    if now < rules.opens_at and not has_begun_test:
        return MarkState.upcoming
    end = rules.last_counted_at or rules.due_at
    if end is None:
        return MarkState.done if begun else MarkState.open
    if now <= end:
        return MarkState.open
    return MarkState.done if begun else MarkState.absent
