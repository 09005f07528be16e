"""Queries on overrides, decisions, and the rules of a class."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, Row, and_, func, select, update
from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.classes.models import Membership, SchoolClass
from server.classes.schemas import display_name
from server.identity.models import Account
from server.marks.models import MarkingPolicy, Override, StateDecision
from server.marks.schemas import ActiveDecision, ActiveOverride, OverrideKey, StudentExercise
from server.marks.states import ClassMarking, Counting, DecidedState, MarkingRules
from server.submissions.models import Submission

#: The names of an author, as `display_name` takes them; all None once the account is gone.
AUTHOR = (Membership.given_name, Membership.family_name, func.coalesce(Account.name, ""))


def _is_active_override(class_id: UUID) -> ColumnElement[bool]:
    return and_(Override.class_id == class_id, Override.withdrawn_at.is_(None))


def load_active_overrides(
    db: Session, class_id: UUID, students: Collection[UUID] | None = None, exercises: Collection[str] | None = None
) -> Mapping[OverrideKey, ActiveOverride]:
    """Load the overrides in force in a class, or those of some students or exercises, in one query.

    Those of deleted assignments are in force again once their assignment is restored.
    """
    seat = and_(Membership.account_id == Override.by, Membership.class_id == Override.class_id)
    query = select(Override, *AUTHOR).outerjoin(Account, Account.id == Override.by).outerjoin(Membership, seat)
    query = query.outerjoin(Assignment, Assignment.id == Override.assignment_id)
    query = query.where(_is_active_override(class_id), Assignment.removed_at.is_(None))
    if students is not None:
        query = query.where(Override.account_id.in_(students))
    if exercises is not None:
        query = query.where(Override.exercise.in_(exercises))
    overrides = {}
    for row, *author in db.execute(query.order_by(Override.account_id, Override.exercise, Override.at)):
        overrides[row.account_id, row.exercise, row.assignment_id] = ActiveOverride(
            row.points,
            row.excused,
            row.reason,
            display_name(*author),
            row.at,
            frozenset(row.based_on),
            row.assignment_id,
        )
    return overrides


def load_prevailing_overrides(
    db: Session, class_id: UUID, students: Collection[UUID] | None = None, exercises: Collection[str] | None = None
) -> Mapping[StudentExercise, ActiveOverride]:
    """Load one override for each student and exercise, whatever the assignment: the one that holds everywhere, else the
    newest."""
    by_pair: dict[StudentExercise, ActiveOverride] = {}
    for (student, exercise, assignment), override in load_active_overrides(db, class_id, students, exercises).items():
        earlier = by_pair.get((student, exercise))
        if earlier is None or assignment is None or (earlier.assignment_id is not None and override.at >= earlier.at):
            by_pair[student, exercise] = override
    return by_pair


def find_active_override(
    db: Session, class_id: UUID, student: UUID, exercise: str, assignment_id: UUID | None
) -> Override | None:
    """Return the override in force of this very scope."""
    scope = Override.assignment_id.is_(None) if assignment_id is None else Override.assignment_id == assignment_id
    query = select(Override).where(
        _is_active_override(class_id), Override.account_id == student, Override.exercise == exercise, scope
    )
    return db.execute(query).scalar_one_or_none()


def load_active_decisions(
    db: Session, class_id: UUID, students: Collection[UUID] | None = None
) -> Mapping[tuple[UUID, UUID], ActiveDecision]:
    """Load the decisions in force in a class, by student and assignment, in one query."""
    seat = and_(Membership.account_id == StateDecision.by, Membership.class_id == class_id)
    query = (
        select(StateDecision, *AUTHOR)
        .join(Assignment, Assignment.id == StateDecision.assignment_id)
        .outerjoin(Account, Account.id == StateDecision.by)
        .outerjoin(Membership, seat)
        .where(Assignment.class_id == class_id, StateDecision.withdrawn_at.is_(None))
    )
    if students is not None:
        query = query.where(StateDecision.account_id.in_(students))
    return {
        (row.account_id, row.assignment_id): ActiveDecision(
            row.id, DecidedState(row.state), row.reason, display_name(*author), row.at
        )
        for row, *author in db.execute(query.order_by(StateDecision.at, StateDecision.id))
    }


def find_active_decision(db: Session, assignment_id: UUID, student: UUID) -> StateDecision | None:
    """Return the decision in force."""
    query = select(StateDecision).where(
        StateDecision.assignment_id == assignment_id,
        StateDecision.account_id == student,
        StateDecision.withdrawn_at.is_(None),
    )
    return db.execute(query).scalar_one_or_none()


def load_decisions_about_account(db: Session, account_id: UUID) -> Sequence[Row[StateDecision, Assignment, str]]:
    """Return every decision ever made about an account, each with its assignment and the name of the class."""
    query = (
        select(StateDecision, Assignment, SchoolClass.name)
        .join(Assignment, Assignment.id == StateDecision.assignment_id)
        .join(SchoolClass, SchoolClass.id == Assignment.class_id)
    )
    return db.execute(
        query.where(StateDecision.account_id == account_id).order_by(StateDecision.at, StateDecision.id)
    ).all()


def move_decisions(db: Session, old: UUID, new: UUID, now: datetime) -> None:
    """Move decisions from a guest to an account, which keeps its own where both have one in force."""
    own = select(StateDecision.assignment_id).where(
        StateDecision.account_id == new, StateDecision.withdrawn_at.is_(None)
    )
    active = StateDecision.withdrawn_at.is_(None)
    of_guest = StateDecision.account_id == old
    db.execute(
        update(StateDecision)
        .where(of_guest, active, StateDecision.assignment_id.in_(own))
        .values(withdrawn_at=now)
        .execution_options(synchronize_session=False)
    )
    db.execute(update(StateDecision).where(of_guest).values(account_id=new))


def load_marking_rules(db: Session, class_id: UUID) -> ClassMarking:
    """Load the rules of a class, by default those of a new one."""
    row = find_marking_policy(db, class_id)
    if row is None:
        return ClassMarking()
    values = (row.not_handed_in, row.late_refused, row.absent, row.unanswered)
    return ClassMarking(MarkingRules(*map(Counting, values)), row.chosen_at is not None, row.version)


def find_marking_policy(db: Session, class_id: UUID) -> MarkingPolicy | None:
    return db.execute(select(MarkingPolicy).where(MarkingPolicy.class_id == class_id)).scalar_one_or_none()


def load_overrides_on_account(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
    """Return every override ever set on an account's marks, each with the name of the class."""
    query = select(Override, SchoolClass.name).join(SchoolClass, SchoolClass.id == Override.class_id)
    return db.execute(query.where(Override.account_id == account_id).order_by(Override.at, Override.id)).all()


def load_overrides_by_author(db: Session, account_id: UUID) -> Sequence[Row[Override, str]]:
    """Return every override ever set by an account, each with the name of the class."""
    query = select(Override, SchoolClass.name).join(SchoolClass, SchoolClass.id == Override.class_id)
    return db.execute(query.where(Override.by == account_id).order_by(Override.at, Override.id)).all()


def move_overrides(db: Session, old: UUID, new: UUID, now: datetime) -> None:
    """Move overrides from a guest to an account, which keeps its own where both have one in force."""
    own = set(_load_active_override_scopes(db, new))
    for override in db.execute(
        select(Override).where(Override.account_id == old, Override.withdrawn_at.is_(None))
    ).scalars():
        if (override.class_id, override.exercise, override.assignment_id) in own:
            override.withdrawn_at = now
    db.flush()
    db.execute(update(Override).where(Override.account_id == old).values(account_id=new))


def _load_active_override_scopes(db: Session, account_id: UUID) -> Sequence[tuple[UUID, str, UUID | None]]:
    query = select(Override.class_id, Override.exercise, Override.assignment_id)
    query = query.where(Override.account_id == account_id, Override.withdrawn_at.is_(None))
    return [(class_id, exercise, assignment) for class_id, exercise, assignment in db.execute(query)]


def load_submission_source(db: Session, submission_id: UUID) -> bytes | None:
    return db.execute(select(Submission.source).where(Submission.id == submission_id)).scalar_one_or_none()
