"""Queries on all that a class's assignments are, as the database tells it: for what is kept while it is the same."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias
from uuid import UUID

from sqlalchemy import Select, select
from sqlalchemy.orm import Session

from server.assignments.models import Assigned, AssignedExercise, Assignment, Exemption, Mode, Sitting
from server.database import Copies, Told, ask, prepared, table_of

Query: TypeAlias = Select[*tuple[Any, ...]]
ASSIGNMENTS, EXEMPTIONS, SITTINGS = Copies(Assignment), Copies(Exemption), Copies(Sitting)
_given, _asked = table_of(Assignment).c, table_of(AssignedExercise).c
_differs, _sat = table_of(Exemption).c, table_of(Sitting).c
MODE = list(_given.keys()).index("mode")
ASKED = len(Assigned._fields)


class ToldAssignments(NamedTuple):
    """The same again: nothing of a class's assignments has changed. `assignments`: each as often as it has exercises,
    with one of them behind it, or once."""

    assignments: Sequence[Told]
    exemptions: Sequence[Told]
    sittings: Sequence[Told]


@dataclass(frozen=True)
class Given:
    """A class's assignments in the order in which they open, and what is of each: sittings by student, of tests."""

    assignments: Sequence[Assignment]
    exercises: Mapping[UUID, Sequence[Assigned]]
    exemptions: Mapping[UUID, Sequence[Exemption]]
    sittings: Mapping[UUID, Mapping[UUID, Sitting]]


def of_class(db: Session, class_id: UUID) -> ToldAssignments:
    """Two queries, three where there are tests."""
    given = _told(db, *_assignments(class_id))
    tests = any(row[MODE] == Mode.test for row in given)
    return ToldAssignments(given, _told(db, *_exemptions(class_id)), _told(db, *_sittings(class_id)) if tests else ())


def _told(db: Session, query: Query, values: dict[str, Any]) -> Sequence[Told]:
    return [tuple(row) for row in ask(db, query, values).all()]


def read(db: Session, told: ToldAssignments) -> Given:
    rows = {row[0]: row[:-ASKED] for row in told.assignments}
    assignments = ASSIGNMENTS.made(db, list(rows.values()))
    exercises = {
        one.id: [Assigned(*row[-ASKED:]) for row in told.assignments if row[0] == key and row[-1] is not None]
        for key, one in zip(rows, assignments, strict=True)
    }
    exemptions: dict[UUID, list[Exemption]] = defaultdict(list)
    for one in EXEMPTIONS.made(db, told.exemptions):
        exemptions[one.assignment_id].append(one)
    sittings: dict[UUID, dict[UUID, Sitting]] = defaultdict(dict)
    for sitting in SITTINGS.made(db, told.sittings):
        sittings[sitting.assignment_id][sitting.account_id] = sitting
    return Given(assignments, exercises, exemptions, sittings)


@prepared
def _assignments(class_id: UUID) -> Query:
    rows = table_of(Assignment).outerjoin(table_of(AssignedExercise), _asked.assignment_id == _given.id)
    query = select(*ASSIGNMENTS.asked, _asked.exercise, _asked.weight).select_from(rows)
    query = query.where(_given.class_id == class_id)
    return query.order_by(_given.opens_at, _given.title, _given.id, _asked.position)


@prepared
def _exemptions(class_id: UUID) -> Query:
    query = select(*EXEMPTIONS.asked).join(table_of(Assignment), _given.id == _differs.assignment_id)
    query = query.where(_given.class_id == class_id, _differs.revoked_at.is_(None))
    return query.order_by(_differs.created_at, _differs.id)


@prepared
def _sittings(class_id: UUID) -> Query:
    query = select(*SITTINGS.asked).join(table_of(Assignment), _given.id == _sat.assignment_id)
    query = query.where(_given.class_id == class_id, _given.mode == Mode.test)
    return query.order_by(_sat.assignment_id, _sat.account_id)
