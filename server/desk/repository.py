"""Queries of the desk across rooms."""

from collections.abc import Collection, Mapping, Sequence
from uuid import UUID

from sqlalchemy import Select, and_, func, select
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Sitting
from server.classes.models import ClassRole, Membership, Status
from server.gradebook.models import Standing
from server.submissions.models import Submission


def count_finished_students(db: Session, class_id: UUID, assignments: Collection[UUID]) -> Mapping[UUID, int]:
    """Count, by assignment, the active students who have solved all of its exercises at any time."""
    finished = _finished_students(class_id, assignments).subquery()
    query = select(finished.c.assignment_id, func.count()).group_by(finished.c.assignment_id)
    return {row[0]: row[1] for row in db.execute(query)}


def load_finished_students(db: Session, class_id: UUID, assignments: Collection[UUID]) -> Sequence[tuple[UUID, UUID]]:
    """Load the pairs of an assignment and an active student who has solved all of its exercises at any time."""
    return [(row[0], row[1]) for row in db.execute(_finished_students(class_id, assignments))]


def _finished_students(class_id: UUID, assignments: Collection[UUID]) -> Select[UUID, UUID]:
    assigned = (
        select(AssignedExercise.assignment_id, func.count().label("total"))
        .where(AssignedExercise.assignment_id.in_(assignments))
        .group_by(AssignedExercise.assignment_id)
        .subquery()
    )
    solved = (
        select(AssignedExercise.assignment_id, Standing.account_id, func.count().label("solved"))
        .join(Standing, Standing.exercise == AssignedExercise.exercise)
        .join(Membership, and_(Membership.account_id == Standing.account_id, Membership.class_id == class_id))
        .where(
            AssignedExercise.assignment_id.in_(assignments),
            Standing.first_success_at.is_not(None),
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
        )
        .group_by(AssignedExercise.assignment_id, Standing.account_id)
        .subquery()
    )
    return select(assigned.c.assignment_id, solved.c.account_id).join(
        solved, and_(solved.c.assignment_id == assigned.c.assignment_id, solved.c.solved == assigned.c.total)
    )


def load_senders(db: Session, class_id: UUID, assignment_id: UUID) -> frozenset[UUID]:
    """Load the members of a class who have ever sent something to an exercise of an assignment."""
    query = (
        select(Submission.account_id)
        .join(AssignedExercise, AssignedExercise.exercise == Submission.exercise)
        .join(Membership, and_(Membership.account_id == Submission.account_id, Membership.class_id == class_id))
        .where(AssignedExercise.assignment_id == assignment_id)
    )
    return frozenset(db.execute(query.distinct()).scalars())


def count_begun_students(db: Session, class_id: UUID, tests: Collection[UUID]) -> Mapping[UUID, int]:
    """Count, by test, the active students who have begun it."""
    query = (
        select(Sitting.assignment_id, func.count())
        .join(Membership, and_(Membership.account_id == Sitting.account_id, Membership.class_id == class_id))
        .where(
            Sitting.assignment_id.in_(tests),
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
        )
        .group_by(Sitting.assignment_id)
    )
    return {row[0]: row[1] for row in db.execute(query)}
