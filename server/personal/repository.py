"""Queries on everything that belongs to an account."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, and_, delete, exists, func, or_, select
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.gradebook.models import ClassOpening, SolutionOpening
from server.identity.models import Account, ApiToken, BrowserSession, FederatedIdentity, Role
from server.polls.models import PollAnswer
from server.submissions.models import Submission, Variant


def load_variants(db: Session, account_id: UUID) -> Sequence[Variant]:
    return (
        db.execute(select(Variant).where(Variant.account_id == account_id).order_by(Variant.exercise)).scalars().all()
    )


def load_solution_openings_by(db: Session, account_id: UUID) -> Sequence[SolutionOpening]:
    query = select(SolutionOpening).where(SolutionOpening.opened_by == account_id)
    return db.execute(query.order_by(SolutionOpening.exercise)).scalars().all()


def load_class_openings_by(db: Session, account_id: UUID) -> Sequence[tuple[ClassOpening, str]]:
    """Load openings of solutions to classes, each with the name of its class."""
    query = select(ClassOpening, SchoolClass.name).join(SchoolClass, SchoolClass.id == ClassOpening.class_id)
    query = query.where(ClassOpening.opened_by == account_id).order_by(ClassOpening.opened_at)
    return [(opening, name) for opening, name in db.execute(query)]


def load_submission_ids_page(db: Session, account_id: UUID, *, after: UUID | None, limit: int) -> Sequence[UUID]:
    """Load a page of an account's submission ids, by keyset pagination."""
    query = select(Submission.id).where(_is_submission_of(account_id))
    query = query if after is None else query.where(Submission.id > after)
    return db.execute(query.order_by(Submission.id).limit(limit)).scalars().all()


def delete_submissions(db: Session, account_id: UUID, limit: int) -> int:
    """Delete up to `limit` submissions with their gradings; return how many."""
    candidates = select(Submission.id).where(_is_submission_of(account_id)).limit(limit)
    return len(db.execute(delete(Submission).where(Submission.id.in_(candidates)).returning(Submission.id)).all())


def _is_submission_of(account_id: UUID) -> ColumnElement[bool]:
    return Submission.account_id == account_id


def load_unreachable_guest_ids(db: Session, before: datetime, limit: int) -> Sequence[UUID]:
    """Load guests created before a time whom no session and no token leads to any more."""
    query = select(Account.id).where(
        Account.role == Role.guest,
        Account.created_at < before,
        ~exists().where(BrowserSession.account_id == Account.id),
        ~exists().where(ApiToken.account_id == Account.id),
    )
    return db.execute(query.limit(limit)).scalars().all()


def delete_idle_guests(db: Session, before: datetime, limit: int) -> int:
    """Delete guests created before a time who have no work and no class; return how many."""
    candidates = select(Account.id).where(_is_idle_guest(before)).limit(limit).with_for_update(skip_locked=True)
    account_ids = db.execute(candidates).scalars().all()
    deleted = delete(Account).where(Account.id.in_(account_ids), _is_idle_guest(before)).returning(Account.id)
    return len(db.execute(deleted).all())


def count_idle_guests(db: Session, before: datetime) -> int:
    return db.execute(select(func.count()).select_from(Account).where(_is_idle_guest(before))).scalar_one()


def _is_idle_guest(before: datetime) -> ColumnElement[bool]:
    return and_(
        Account.role == Role.guest,
        Account.created_at < before,
        ~exists().where(Submission.account_id == Account.id),
        ~exists().where(Membership.account_id == Account.id),
        ~exists().where(PollAnswer.account_id == Account.id),
    )


def load_inactive_student_ids(db: Session, before: datetime, limit: int) -> Sequence[UUID]:
    """Load students without any activity since a time, whatever their classes."""
    query = select(Account.id).where(Account.role == Role.student, _is_inactive(before), ~_is_class_staff())
    return db.execute(query.order_by(Account.created_at, Account.id).limit(limit)).scalars().all()


def load_departed_student_ids(db: Session, before: datetime, limit: int) -> Sequence[UUID]:
    """Load inactive students whose account a class list, or another system, created and whose classes had all ended by
    then.

    A class ends for a student when they leave it, or when it is archived.
    """
    own_membership = Membership.account_id == Account.id
    created_by_roster = or_(
        exists().where(own_membership, Membership.created_by_list),
        and_(
            Account.login.is_(None),
            exists().where(own_membership),
            exists().where(FederatedIdentity.account_id == Account.id),
        ),
    )
    ongoing = or_(
        and_(
            Membership.status != Status.left,
            or_(SchoolClass.archived_at.is_(None), SchoolClass.archived_at >= before),
        ),
        and_(Membership.status == Status.left, Membership.left_at >= before),
    )
    in_ongoing_class = exists().where(own_membership, SchoolClass.id == Membership.class_id, ongoing)
    query = select(Account.id).where(
        Account.role == Role.student, created_by_roster, ~in_ongoing_class, _is_inactive(before), ~_is_class_staff()
    )
    return db.execute(query.order_by(Account.created_at, Account.id).limit(limit)).scalars().all()


def load_accounts_sorted_by_name(db: Session, accounts: Sequence[UUID]) -> Sequence[Account]:
    """Load these accounts, ordered by name."""
    query = select(Account).where(Account.id.in_(accounts)).order_by(Account.name, Account.id)
    return db.execute(query).scalars().all()


def _is_inactive(before: datetime) -> ColumnElement[bool]:
    """Nothing submitted, no login, no token made or used, no class visited since then."""
    return and_(
        Account.created_at < before,
        ~exists().where(Submission.account_id == Account.id, Submission.created_at >= before),
        ~exists().where(BrowserSession.account_id == Account.id, BrowserSession.created_at >= before),
        ~exists().where(
            ApiToken.account_id == Account.id,
            or_(ApiToken.created_at >= before, ApiToken.last_used_at >= before),
        ),
        ~exists().where(Membership.account_id == Account.id, Membership.last_seen_at >= before),
    )


def _is_class_staff() -> ColumnElement[bool]:
    """Assistants and teachers of a class are kept, whatever the role of their account."""
    return exists().where(
        Membership.account_id == Account.id,
        Membership.role.in_((ClassRole.assistant, ClassRole.teacher)),
        Membership.status == Status.active,
    )
