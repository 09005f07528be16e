"""Queries on what partners have sent for a student who hands in with them."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy import and_
from sqlalchemy.orm import Session

from server.assignments.models import AssignedExercise, Assignment, AttemptSelection
from server.assignments.team_repository import MINE, OTHER, join_partner_names, select_shared_work
from server.base.errors import NotFound
from server.classes.models import Membership
from server.classes.schemas import display_name
from server.database import END_OF_TIME
from server.gradebook.models import Grading
from server.gradebook.service import find_attempt
from server.identity.models import Account
from server.submissions.models import Submission


@dataclass(frozen=True)
class TeammateAttempt:
    """A graded attempt that a partner, of that name, has sent for a student too; `score` in [0, 1]."""

    id: UUID
    partner: str
    sent_at: datetime
    score: float


TeamAttempts = Mapping[tuple[UUID, str], TeammateAttempt]


def load_teammate_attempts(
    db: Session,
    students: Collection[UUID],
    *,
    class_id: UUID | None = None,
    exercise: str | None = None,
    until: datetime | None = None,
) -> TeamAttempts:
    """Load by student and exercise the attempt of a partner that counts, sent while they handed in together.

    It is the latest where the assignment takes the last attempt, else the best. `class_id` and `exercise`: in this
    class, at this exercise only. `until` is the time of the latest attempt that is read (None: without an end).
    """
    pairs = select_shared_work(
        Submission.created_at,
        *(MINE.account_id, Submission.exercise),
        *(Submission.id, Submission.created_at, Grading.score, Assignment.counts),
        *(Membership.given_name, Membership.family_name, Account.name),
    )
    sent = and_(Submission.account_id == OTHER.account_id, Submission.exercise == AssignedExercise.exercise)
    query = (
        join_partner_names(pairs)
        .join(Submission, sent)
        .join(Grading, Grading.id == Submission.grading_id)
        .where(MINE.account_id.in_(students), Submission.created_at <= (until or END_OF_TIME))
        .order_by(Submission.created_at, Submission.id)
    )
    if class_id is not None:
        query = query.where(Assignment.class_id == class_id)
    if exercise is not None:
        query = query.where(AssignedExercise.exercise == exercise)
    counted: dict[tuple[UUID, str], TeammateAttempt] = {}
    for student, name, id, sent_at, score, counts, *names in db.execute(query) if students else ():
        if score is None:
            continue
        attempt = TeammateAttempt(id, display_name(*names), sent_at, score)
        earlier = counted.get((student, name))
        if earlier is None or counts == AttemptSelection.last or score > earlier.score:
            counted[student, name] = attempt
    return counted


def find_teammate_attempt(db: Session, account: Account | None, exercise: str) -> TeammateAttempt | None:
    """Return what a partner has sent for the account too; None without any, and where a test withholds it."""
    if account is None:
        return None
    shared = load_teammate_attempts(db, [account.id], exercise=exercise).get((account.id, exercise))
    if shared is None:
        return None
    try:
        find_attempt(db, account, shared.id)
    except NotFound:
        return None
    return shared
