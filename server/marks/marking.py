"""Compute the marks of an assignment from what its students sent: pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from uuid import UUID

from server.assignments.class_assignments import ClassAssignments
from server.assignments.counting import SendTimingJudge, mark_attempts
from server.assignments.feedback import SittingStage, sitting_stage
from server.assignments.models import Assignment, AttemptSelection, Mode, Sitting, WeightedExercise
from server.assignments.rules import OUTSIDE, Rules, SendingWindow, is_assigned_to, rules_in_force
from server.assignments.team_rules import Partnership, TeamPlace, list_partnerships, team_rules_in_force
from server.classes.schemas import StudentRecord
from server.gradebook.histories import Attempts, cached_per_history
from server.marks.schemas import ActiveDecision, ActiveOverride, AssignmentMark, ExerciseMark, OverrideKey
from server.marks.states import DecidedState, MarkingRules, MarkState

ENDED_STAGES = frozenset((SittingStage.over, SittingStage.missed, SittingStage.shown))
DECIDED: Mapping[DecidedState, MarkState] = {
    DecidedState.absent: MarkState.absent,
    DecidedState.excused: MarkState.excused,
    DecidedState.zero: MarkState.done,
}


@dataclass(frozen=True)
class TeacherChoices:
    """What the teachers of a class have set: overrides, decisions by student and assignment, the rules of the mean."""

    overrides: Mapping[OverrideKey, ActiveOverride]
    decisions: Mapping[tuple[UUID, UUID], ActiveDecision]
    marking: MarkingRules

    @cached_property
    def overrides_by_student(self) -> Mapping[UUID, OwnOverrides]:
        """Return those of each student who has some, by exercise and assignment."""
        by_student: dict[UUID, dict[tuple[str, UUID | None], ActiveOverride]] = {}
        for (student, exercise, assignment), override in self.overrides.items():
            by_student.setdefault(student, {})[exercise, assignment] = override
        return by_student


#: Of one student, by exercise and assignment; None for all assignments.
OwnOverrides = Mapping[tuple[str, UUID | None], ActiveOverride]
NO_OVERRIDES: OwnOverrides = {}


@dataclass(frozen=True, eq=False)
class AssignmentMarker:
    """Marks one assignment of a class. `rules` are those in force, by student."""

    assignment: Assignment
    exercises: tuple[WeightedExercise, ...]
    sittings: Mapping[UUID, Sitting]
    rules: Mapping[UUID, Rules]
    teams: Sequence[TeamPlace] = ()

    @classmethod
    def build_for_assignment(
        cls, assignment: Assignment, assigned: ClassAssignments, students: Sequence[StudentRecord]
    ) -> AssignmentMarker:
        exemptions, teams = assigned.exemptions.get(assignment.id, ()), assigned.teams.get(assignment.id, ())
        common = replace(rules_in_force(assignment, (), assignment.class_id, ()), is_concerned=True)
        unconcerned = replace(common, is_concerned=False)
        rules = {
            student.id: team_rules_in_force(assignment, exemptions, student.id, student.groups, teams)
            if exemptions or teams
            else (common if is_assigned_to(assignment, student.groups) else unconcerned)
            for student in students
        }
        exercises = tuple(assigned.exercises.get(assignment.id, ()))
        return cls(assignment, exercises, assigned.sittings.get(assignment.id, {}), rules, teams)

    def iter_change_instants(self) -> Iterator[datetime | None]:
        """Yield every time at which a mark may change by itself: all that `mark_student` and `is_test_withheld` compare
        with now."""
        yield self.assignment.released_at
        for student, rules in self.rules.items():
            yield from (rules.opens_at, rules.due_at, rules.closes_at)
            if sitting := self.sittings.get(student):
                yield rules.latest_sitting_end(sitting.began_at)

    def mark_student(
        self,
        student: UUID,
        attempts: Mapping[UUID, Mapping[str, Attempts]],
        choices: TeacherChoices,
        now: datetime,
    ) -> AssignmentMark:
        """Return the mark of one student; `attempts`: by account and exercise."""
        rules, sitting = self.rules[student], self.sittings.get(student)
        shares = list_partnerships(self.teams, student) if self.teams else ()
        partners = tuple(sorted(share.partner.name for share in shares if share.until is None))
        own, decision = attempts.get(student, NO_ATTEMPTS), choices.decisions.get((student, self.assignment.id))
        is_test, counts = self.assignment.mode == Mode.test, AttemptSelection(self.assignment.counts)
        windows = SendingWindow(rules, sitting)
        if shares:
            own = {name: add_team_attempts(own.get(name, ()), name, attempts, shares) for name, _ in self.exercises}
        if is_test:
            own = {name: _attempts_in_sitting(windows, own.get(name, ())) for name, _ in self.exercises}
        overrides = choices.overrides_by_student.get(student, NO_OVERRIDES)
        marks = mark_exercises(own, self.assignment.id, self.exercises, windows, counts, overrides)
        # A test ends for a student who has handed in, whose time is over, or once its results are out.
        ended = is_test and sitting_stage(self.assignment, rules, sitting, now) in ENDED_STAGES
        if not windows.concerns_student:
            state, decision = MarkState.not_concerned, None
        elif decision is not None:
            state = DECIDED[decision.state]
        else:
            state = compute_mark_state(rules, marks, now, has_begun_test=sitting is not None, ended=ended)
        return _cached_assignment_mark(
            own, self.assignment.id, rules, state, marks, ended, choices.marking, decision, partners
        )


NO_ATTEMPTS: Mapping[str, Attempts] = {}


def _attempts_in_sitting(windows: SendingWindow, attempts: Attempts) -> Attempts:
    """Return what a student sent in the sitting of a test."""
    return [attempt for attempt in attempts if windows.judge_timing(attempt.sent_at) is not OUTSIDE]


@cached_per_history
def mark_exercises(
    own: Mapping[str, Attempts],
    assignment: UUID,
    exercises: tuple[WeightedExercise, ...],
    windows: SendingWindow,
    counts: AttemptSelection,
    overrides: OwnOverrides,
) -> tuple[ExerciseMark, ...]:
    """Return the marks of a student at the exercises of an assignment; an override for it precedes one for all."""
    marks = []
    for exercise, weight in exercises:
        override = overrides.get((exercise, assignment)) or overrides.get((exercise, None)) if overrides else None
        marks.append(mark_exercise(exercise, weight, own.get(exercise, ()), windows, counts, override))
    return tuple(marks)


@cached_per_history
def _cached_assignment_mark(
    own: Mapping[str, Attempts],
    assignment: UUID,
    rules: Rules,
    state: MarkState,
    marks: tuple[ExerciseMark, ...],
    ended: bool,
    marking: MarkingRules,
    decision: ActiveDecision | None,
    partners: tuple[str, ...],
) -> AssignmentMark:
    return AssignmentMark(rules, state, marks, ended, marking, decision, partners)


def add_team_attempts(
    own: Attempts, exercise: str, attempts: Mapping[UUID, Mapping[str, Attempts]], shares: Sequence[Partnership]
) -> Attempts:
    """Return a student's attempts with those that partners sent while they handed in together, oldest first."""
    others = (
        attempt
        for share in shares
        for attempt in attempts.get(share.partner.account_id, NO_ATTEMPTS).get(exercise, ())
        if share.covers(attempt.sent_at)
    )
    by_id = {attempt.id: attempt for attempt in (*own, *others)}
    return sorted(by_id.values(), key=lambda attempt: (attempt.sent_at, attempt.id))


def mark_exercise(
    exercise: str,
    weight: float,
    attempts: Attempts,
    times: SendTimingJudge,
    counts: AttemptSelection,
    override: ActiveOverride | None,
) -> ExerciseMark:
    """Return the mark of one student at one exercise, from the attempts and the override in force."""
    if not attempts:
        return ExerciseMark(exercise, weight, None, None, None, 0, override)
    result = mark_attempts(times, counts, attempts)
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
        sent=len(attempts),
    )


def compute_mark_state(
    rules: Rules,
    marks: Sequence[ExerciseMark],
    now: datetime,
    *,
    has_begun_test: bool = False,
    ended: bool = False,
) -> MarkState:
    """Return the state of an assignment for a student. An override counts as something sent.

    A test is open to a student who has begun it, or still may, whatever its dates have become; once it is over, who has
    begun it has handed in a copy, perhaps a blank one. `ended`: the student can send nothing more, whatever the dates.
    """
    if rules.excused or (marks and all(mark.excused for mark in marks)):
        return MarkState.excused
    over = _state_after_end(marks, has_begun_test=has_begun_test)
    if ended:
        return over
    if now < rules.opens_at and not has_begun_test:
        return MarkState.upcoming
    end = rules.latest_counting_time or rules.due_at
    begun = any(mark.points is not None for mark in marks)
    if rules.is_test or (end is not None and now <= end) or (end is None and not begun):
        return MarkState.open
    return over


def _state_after_end(marks: Sequence[ExerciseMark], *, has_begun_test: bool) -> MarkState:
    if has_begun_test or any(mark.points is not None for mark in marks):
        return MarkState.done
    return MarkState.late_refused if any(mark.is_refused_as_late for mark in marks) else MarkState.not_handed_in
