"""A student's assignments with the rules in force for them. Functions work inside the caller's transaction."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository, sitting_repository
from server.assignments.models import Assignment, Exemption, Mode, WeightedExercise
from server.assignments.rules import Rules, is_assigned_to
from server.assignments.stages import AssignmentStage, assignment_stage
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import TeamPlace, list_current_partners, team_rules_in_force
from server.base.errors import NotFound

UNKNOWN = "Ce devoir n’existe pas dans cette classe."


@dataclass(frozen=True)
class StudentAssignment:
    """An assignment for one student, with those who hand it in with them. The exercises of a test stay secret until it
    opens."""

    assignment: Assignment
    rules: Rules
    exercises: tuple[WeightedExercise, ...]
    exemptions: tuple[Exemption, ...]
    stage: AssignmentStage
    partners: tuple[TeamPlace, ...] = ()

    @property
    def hides_exercises(self) -> bool:
        """Whether its exercises are still secret."""
        return self.assignment.mode == Mode.test and self.stage is AssignmentStage.upcoming


def load_assignments_for_student(
    db: Session, class_id: UUID, account_id: UUID, labels: Collection[str], now: datetime
) -> Sequence[StudentAssignment]:
    """Load the assignments of a class that concern a student, in the order in which they open, in three queries."""
    assignments = repository.load_class_assignments(db, class_id)
    return _with_student_rules(db, [(assignment, labels) for assignment in assignments], account_id, now)


def load_student_assignment(
    db: Session, assignment: Assignment, account_id: UUID, labels: Collection[str], now: datetime
) -> StudentAssignment:
    """Load an assignment for a student. Raises NotFound where it does not concern them."""
    own = _with_student_rules(db, [(assignment, labels)], account_id, now)
    if not own:
        raise NotFound(UNKNOWN)
    return own[0]


def load_open_assignments(
    db: Session, account_id: UUID, now: datetime, exercise: str | None = None
) -> Sequence[StudentAssignment]:
    """Load the assignments of all a student's classes whose attempts still count, by due date, and all tests, which
    their student may still sit; with `exercise`, those that contain it. Takes one query without assignments, two else,
    three where some have exemptions.
    """
    loaded = repository.load_student_assignments(db, account_id, now, exercise)
    rows = [(assignment, groups) for assignment, groups, _ in loaded]
    exempted = [assignment.id for assignment, _, has_exemptions in loaded if has_exemptions]
    own = _with_student_rules(db, rows, account_id, now, exempted)
    counting = [
        each
        for each in own
        if each.assignment.mode == Mode.test or each.stage in {AssignmentStage.open, AssignmentStage.late}
    ]
    return sorted(counting, key=lambda own: (own.rules.due_at is None, own.rules.due_at or now, own.assignment.title))


def filter_due_soon(
    assignments: Collection[StudentAssignment], now: datetime, soon: timedelta
) -> Sequence[StudentAssignment]:
    """Return those due within `soon` or overdue, without the excused ones."""
    return [
        own
        for own in assignments
        if own.rules.due_at is not None and own.rules.due_at <= now + soon and not own.rules.excused
    ]


def _load_sat_tests(
    db: Session, rows: Sequence[tuple[Assignment, Collection[str]]], account_id: UUID
) -> Collection[UUID]:
    """Load the tests of other groups that a student has begun: they stay theirs, whatever their groups have become."""
    if not any(assignment.mode == Mode.test and not is_assigned_to(assignment, labels) for assignment, labels in rows):
        return ()
    return {sitting.assignment_id for sitting, _ in sitting_repository.load_account_sittings(db, account_id)}


def _with_student_rules(
    db: Session,
    rows: Sequence[tuple[Assignment, Collection[str]]],
    account_id: UUID,
    now: datetime,
    exempted: Collection[UUID] | None = None,
) -> Sequence[StudentAssignment]:
    """Add a student's rules to the assignments that concern them, or that they have sat.

    `exempted`: the assignments with exemptions; None: unknown.
    """
    sat = _load_sat_tests(db, rows, account_id)
    rows = [row for row in rows if is_assigned_to(*row) or row[0].id in sat]
    if not rows:
        return []
    names = [assignment.id for assignment, _ in rows]
    exempted = names if exempted is None else exempted
    exercises = repository.load_exercises(db, names)
    exemptions = repository.load_exemptions(db, exempted) if exempted else {}
    teams = load_places_of_team_assignments(db, [assignment for assignment, _ in rows])
    result = []
    for assignment, labels in rows:
        all_exemptions = exemptions.get(assignment.id, ())
        places = teams.get(assignment.id, ())
        rules = team_rules_in_force(assignment, all_exemptions, account_id, labels, places)
        own = tuple(
            each
            for each in all_exemptions
            if each.revoked_at is None and (each.account_id == account_id or each.label in labels)
        )
        chosen = tuple(exercises.get(assignment.id, ()))
        partners = list_current_partners(places, account_id)
        result.append(StudentAssignment(assignment, rules, chosen, own, assignment_stage(rules, now), partners))
    return result
