"""What a student is to do: their assignments with the rules in force for them. Inside the caller's transaction."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository
from server.assignments.models import Assignment, Exemption, Mode, WeightedExercise
from server.assignments.rules import Rules, rules_in_force
from server.assignments.stages import AssignmentStage, assignment_stage


@dataclass(frozen=True)
class StudentAssignment:
    """An assignment as one student has it. The exercises of a test stay unknown until it opens."""

    assignment: Assignment
    rules: Rules
    exercises: tuple[WeightedExercise, ...]
    exemptions: tuple[Exemption, ...]
    stage: AssignmentStage

    @property
    def hides_exercises(self) -> bool:
        """Whether its exercises are not to be told yet."""
        return self.assignment.mode == Mode.test and self.stage is AssignmentStage.upcoming


def load_class_assignments(
    db: Session, class_id: UUID, account_id: UUID, labels: Collection[str], now: datetime
) -> Sequence[StudentAssignment]:
    """All of a class, in the order in which they open; three queries."""
    return _as_of(db, [(one, labels) for one in repository.load_class_assignments(db, class_id)], account_id, now)


def load_student_assignment(
    db: Session, assignment: Assignment, account_id: UUID, labels: Collection[str], now: datetime
) -> StudentAssignment:
    return _as_of(db, [(assignment, labels)], account_id, now)[0]


def load_open_assignments(
    db: Session, account_id: UUID, now: datetime, exercise: str | None = None
) -> Sequence[StudentAssignment]:
    """What one may still send something for, in any class where one learns; those with this exercise.

    The first to be due is first; one query where one has no assignment, two else, three where some is another one for
    some.
    """
    given = repository.load_student_assignments(db, account_id, now, exercise)
    rows = [(assignment, groups) for assignment, groups, _ in given]
    differing = [assignment.id for assignment, _, differs in given if differs]
    mine = _as_of(db, rows, account_id, now, differing)
    found = [one for one in mine if one.stage in {AssignmentStage.open, AssignmentStage.late}]
    return sorted(found, key=lambda one: (one.rules.due_at is None, one.rules.due_at or now, one.assignment.title))


def due_soon(found: Collection[StudentAssignment], now: datetime, soon: timedelta) -> Sequence[StudentAssignment]:
    """Those of which the due date comes soon, or has just gone by while what is sent still counts; not the excused."""
    return [
        one
        for one in found
        if one.rules.due_at is not None and one.rules.due_at <= now + soon and not one.rules.excused
    ]


def _as_of(
    db: Session,
    rows: Sequence[tuple[Assignment, Collection[str]]],
    account_id: UUID,
    now: datetime,
    differing: Collection[UUID] | None = None,
) -> Sequence[StudentAssignment]:
    """`differing`: those that are known to have exemptions, where that is known."""
    if not rows:
        return []
    names = [assignment.id for assignment, _ in rows]
    asked = names if differing is None else differing
    exercises, exemptions = repository.load_exercises(db, names), repository.load_exemptions(db, asked) if asked else {}
    found = []
    for assignment, labels in rows:
        theirs = exemptions.get(assignment.id, ())
        rules = rules_in_force(assignment, theirs, account_id, labels)
        mine = tuple(one for one in theirs if one.account_id == account_id or one.label in labels)
        found.append(
            StudentAssignment(
                assignment, rules, tuple(exercises.get(assignment.id, ())), mine, assignment_stage(rules, now)
            )
        )
    return found
