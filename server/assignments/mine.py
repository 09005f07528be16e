"""What a student is to do: their assignments with the rules in force for them. Inside the caller's transaction."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import repository
from server.assignments.models import Assigned, Assignment, Exemption, Mode
from server.assignments.rules import Rules, in_force
from server.assignments.states import Stage, stage


@dataclass(frozen=True)
class Mine:
    """An assignment as one student has it. The exercises of a test stay unknown until it opens."""

    assignment: Assignment
    rules: Rules
    exercises: tuple[Assigned, ...]
    exemptions: tuple[Exemption, ...]
    stage: Stage

    @property
    def secret(self) -> bool:
        """Whether its exercises are not to be told yet."""
        return self.assignment.mode == Mode.test and self.stage is Stage.upcoming


def of_class(db: Session, class_id: UUID, account_id: UUID, labels: Collection[str], now: datetime) -> Sequence[Mine]:
    """All of a class, in the order in which they open; three queries."""
    return _as_of(db, [(one, labels) for one in repository.of_class(db, class_id)], account_id, now)


def one(db: Session, assignment: Assignment, account_id: UUID, labels: Collection[str], now: datetime) -> Mine:
    return _as_of(db, [(assignment, labels)], account_id, now)[0]


def running(db: Session, account_id: UUID, now: datetime, exercise: str | None = None) -> Sequence[Mine]:
    """What one may still send something for, in any class where one learns; those with this exercise.

    The first to be due is first; one query where one has no assignment, two else, three where some is another one for
    some.
    """
    given = repository.given_to(db, account_id, now, exercise)
    rows = [(assignment, groups) for assignment, groups, _ in given]
    differing = [assignment.id for assignment, _, differs in given if differs]
    mine = _as_of(db, rows, account_id, now, differing)
    found = [one for one in mine if one.stage in {Stage.open, Stage.late}]
    return sorted(found, key=lambda one: (one.rules.due_at is None, one.rules.due_at or now, one.assignment.title))


def due_within(found: Collection[Mine], now: datetime, soon: timedelta) -> Sequence[Mine]:
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
) -> Sequence[Mine]:
    """`differing`: those that are known to have exemptions, where that is known."""
    if not rows:
        return []
    names = [assignment.id for assignment, _ in rows]
    asked = names if differing is None else differing
    exercises, exemptions = repository.exercises(db, names), repository.exemptions(db, asked) if asked else {}
    found = []
    for assignment, labels in rows:
        theirs = exemptions.get(assignment.id, ())
        rules = in_force(assignment, theirs, account_id, labels)
        mine = tuple(one for one in theirs if one.account_id == account_id or one.label in labels)
        found.append(Mine(assignment, rules, tuple(exercises.get(assignment.id, ())), mine, stage(rules, now)))
    return found
