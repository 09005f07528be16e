"""The attempts of a person who is erased that count for others too: they become theirs."""

from __future__ import annotations

from uuid import UUID

from sqlalchemy import select
from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.assignments import team_repository
from server.assignments.team_rules import list_partnerships
from server.gradebook import service as gradebook
from server.submissions.models import Submission


def give_team_attempts_to_partners(db: Session, account_id: UUID, class_id: UUID | None = None) -> None:
    """Give to a partner what this account has sent for both, in one class or in all. The texts of the attempts stay as
    they were sent; nothing says any more who sent them."""
    given = {
        assignment.id
        for _, assignment, _ in team_repository.load_team_history(db, account_id)
        if class_id in {None, assignment.class_id}
    }
    exercises = assignments.load_exercises(db, given) if given else {}
    for assignment_id, places in team_repository.load_team_places(db, given).items():
        names = [row.exercise for row in exercises.get(assignment_id, ())]
        for share in reversed(list_partnerships(places, account_id)):
            query = select(Submission.id).where(
                Submission.account_id == account_id,
                Submission.exercise.in_(names),
                Submission.created_at >= share.since,
            )
            query = query if share.until is None else query.where(Submission.created_at < share.until)
            shared = db.execute(query).scalars().all()
            if shared:
                gradebook.hand_over_attempts(db, account_id, share.partner.account_id, shared)
