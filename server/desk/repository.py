"""Queries of the desk across rooms."""

from collections.abc import Collection, Mapping
from uuid import UUID

from sqlalchemy import Select, and_, func, select
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise
from server.classes.models import ClassRole, Membership, Status
from server.database import prepared_statement, select_core
from server.gradebook.models import Standing


@prepared_statement
def _finished(class_id: UUID, assignments: Collection[UUID]) -> Select[UUID, int]:
    asked = (
        select(AssignedExercise.assignment_id, func.count().label("asked"))
        .where(AssignedExercise.assignment_id.in_(assignments))
        .group_by(AssignedExercise.assignment_id)
        .subquery()
    )
    solved = (
        select(AssignedExercise.assignment_id, Standing.account_id, func.count().label("solved"))
        .join(Standing, Standing.exercise == AssignedExercise.exercise)
        .join(
            Membership,
            and_(Membership.account_id == Standing.account_id, Membership.class_id == class_id),
        )
        .where(
            AssignedExercise.assignment_id.in_(assignments),
            Standing.first_success_at.is_not(None),
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
        )
        .group_by(AssignedExercise.assignment_id, Standing.account_id)
        .subquery()
    )
    return (
        select(asked.c.assignment_id, func.count())
        .join(solved, and_(solved.c.assignment_id == asked.c.assignment_id, solved.c.solved == asked.c.asked))
        .group_by(asked.c.assignment_id)
    )


def finished(db: Session, class_id: UUID, assignments: Collection[UUID]) -> Mapping[UUID, int]:
    """How many students of the class have once succeeded in every exercise of each assignment, whenever that was."""
    return {row[0]: row[1] for row in select_core(db, *_finished(class_id, assignments))}
