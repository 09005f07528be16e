"""Queries of the desk across rooms. Lists never read a source, a verdict or a figure."""

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from uuid import UUID

from sqlalchemy import and_, func, select
from sqlalchemy.orm import Session

from server.assignments.counting import Sent
from server.assignments.models import AssignedExercise
from server.classes.models import Membership, Seat, Status
from server.gradebook.models import Grading, Standing
from server.submissions.models import Submission


def sent(db: Session, account_id: UUID, exercises: Collection[str]) -> Mapping[str, Sequence[Sent]]:
    """The graded attempts of an account at each of these exercises, but errors of ours."""
    query = (
        select(Submission.exercise, Submission.id, Submission.created_at, Grading.score)
        .join(Grading, Grading.id == Submission.grading_id)
        .where(
            Submission.account_id == account_id,
            Submission.exercise.in_(exercises),
            Grading.score.is_not(None),  # an error of ours has none
        )
    )
    found: dict[str, list[Sent]] = defaultdict(list)
    for exercise, name, sent_at, score in db.execute(query):
        if score is not None:
            found[exercise].append(Sent(name, sent_at, score))
    return found


def finished(db: Session, class_id: UUID, assignments: Collection[UUID]) -> Mapping[UUID, int]:
    """How many students of the class have once succeeded in every exercise of each assignment, whenever that was."""
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
            Membership.role == Seat.student,
            Membership.status == Status.active,
        )
        .group_by(AssignedExercise.assignment_id, Standing.account_id)
        .subquery()
    )
    query = (
        select(asked.c.assignment_id, func.count())
        .join(solved, and_(solved.c.assignment_id == asked.c.assignment_id, solved.c.solved == asked.c.asked))
        .group_by(asked.c.assignment_id)
    )
    return {row[0]: row[1] for row in db.execute(query)}
