"""Load all assignments of a class at once, with what differs for some of its students."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from uuid import UUID

from sqlalchemy import inspect, select
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Assignment, Exemption, Mode, Sitting, WeightedExercise
from server.assignments.team_repository import load_places_of_team_assignments
from server.assignments.team_rules import TeamPlace, list_partnerships
from server.database import Base


@dataclass(frozen=True, eq=False)
class ClassAssignments:
    """The assignments of a class in the order in which they open, and by assignment: its exercises, its exemptions,
    revoked ones included, for tests the sittings by student, and the teams, former ones included."""

    assignments: Sequence[Assignment]
    exercises: Mapping[UUID, Sequence[WeightedExercise]]
    exemptions: Mapping[UUID, Sequence[Exemption]]
    sittings: Mapping[UUID, Mapping[UUID, Sitting]]
    teams: Mapping[UUID, tuple[TeamPlace, ...]] = field(default_factory=dict)

    def find_partners(self, students: Collection[UUID]) -> frozenset[UUID]:
        """Return those who hand in, or handed in, with some of these students."""
        shares = (list_partnerships(places, student) for places in self.teams.values() for student in students)
        return frozenset(share.partner.account_id for own in shares for share in own)

    @cached_property
    def version(self) -> Hashable:
        """Every value that was loaded: equal versions mean equal assignments."""
        sittings = chain.from_iterable(by_student.values() for by_student in self.sittings.values())
        return (
            _row_values(self.assignments),
            tuple((name, tuple(exercises)) for name, exercises in self.exercises.items()),
            _row_values(chain.from_iterable(self.exemptions.values())),
            _row_values(sittings),
            tuple(self.teams.items()),
        )


def _row_values(rows: Iterable[Base]) -> Hashable:
    return tuple(tuple(getattr(row, name) for name in inspect(type(row)).column_attrs.keys()) for row in rows)  # noqa: SIM118


def load_class_assignments(db: Session, class_id: UUID, only: Collection[UUID] | None = None) -> ClassAssignments:
    """Load them in two queries, one more for tests, and for teams; `only`: with the sittings of these alone."""
    query = (
        select(Assignment, AssignedExercise.exercise, AssignedExercise.weight)
        .outerjoin(AssignedExercise, AssignedExercise.assignment_id == Assignment.id)
        .where(Assignment.class_id == class_id, Assignment.removed_at.is_(None))
        .order_by(Assignment.opens_at, Assignment.title, Assignment.id, AssignedExercise.position)
    )
    exercises: dict[UUID, list[WeightedExercise]] = {}
    assignments: dict[UUID, Assignment] = {}
    for assignment, exercise, weight in db.execute(query):
        assignments[assignment.id] = assignment
        rows = exercises.setdefault(assignment.id, [])
        if exercise is not None:
            rows.append(WeightedExercise(exercise, weight))
    has_tests = any(assignment.mode == Mode.test for assignment in assignments.values())
    return ClassAssignments(
        assignments=list(assignments.values()),
        exercises=exercises,
        exemptions=_load_exemptions(db, class_id),
        sittings=_load_sittings(db, class_id, only) if has_tests else {},
        teams=load_places_of_team_assignments(db, assignments.values()),
    )


def _load_exemptions(db: Session, class_id: UUID) -> Mapping[UUID, Sequence[Exemption]]:
    query = select(Exemption).join(Assignment, Assignment.id == Exemption.assignment_id)
    query = query.where(Assignment.class_id == class_id, Assignment.removed_at.is_(None))
    exemptions: dict[UUID, list[Exemption]] = defaultdict(list)
    for exemption in db.execute(query.order_by(Exemption.created_at, Exemption.id)).scalars():
        exemptions[exemption.assignment_id].append(exemption)
    return exemptions


def _load_sittings(db: Session, class_id: UUID, only: Collection[UUID] | None) -> Mapping[UUID, Mapping[UUID, Sitting]]:
    query = select(Sitting).join(Assignment, Assignment.id == Sitting.assignment_id)
    query = query.where(Assignment.class_id == class_id, Assignment.removed_at.is_(None), Assignment.mode == Mode.test)
    query = query if only is None else query.where(Sitting.account_id.in_(only))
    sittings: dict[UUID, dict[UUID, Sitting]] = defaultdict(dict)
    for sitting in db.execute(query.order_by(Sitting.assignment_id, Sitting.account_id)).scalars():
        sittings[sitting.assignment_id][sitting.account_id] = sitting
    return sittings
