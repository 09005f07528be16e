"""Queries on all that hangs on an account."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import ColumnElement, and_, delete, exists, func, or_, select
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.gradebook.models import ClassOpening, SolutionOpening
from server.identity.models import Account, ApiToken, BrowserSession, Role
from server.polls.models import PollAnswer
from server.submissions.models import Submission, Variant


def variants_of(db: Session, account_id: UUID) -> Sequence[Variant]:
    return (
        db.execute(select(Variant).where(Variant.account_id == account_id).order_by(Variant.exercise)).scalars().all()
    )


def solution_openings_by(db: Session, account_id: UUID) -> Sequence[SolutionOpening]:
    query = select(SolutionOpening).where(SolutionOpening.opened_by == account_id)
    return db.execute(query.order_by(SolutionOpening.exercise)).scalars().all()


def class_openings_by(db: Session, account_id: UUID) -> Sequence[tuple[ClassOpening, str]]:
    """Each with the name of its class."""
    query = select(ClassOpening, SchoolClass.name).join(SchoolClass, SchoolClass.id == ClassOpening.class_id)
    query = query.where(ClassOpening.opened_by == account_id).order_by(ClassOpening.opened_at)
    return [(opening, name) for opening, name in db.execute(query)]


def submission_ids(db: Session, account_id: UUID, *, after: UUID | None, most: int) -> Sequence[UUID]:
    """The names of some of an account's submissions, in the order of their names."""
    query = select(Submission.id).where(_sent_by(account_id))
    query = query if after is None else query.where(Submission.id > after)
    return db.execute(query.order_by(Submission.id).limit(most)).scalars().all()


def delete_submissions(db: Session, account_id: UUID, most: int) -> int:
    """Some of an account's submissions with their gradings; how many."""
    some = select(Submission.id).where(_sent_by(account_id)).limit(most)
    return len(db.execute(delete(Submission).where(Submission.id.in_(some)).returning(Submission.id)).all())


def _sent_by(account_id: UUID) -> ColumnElement[bool]:
    return Submission.account_id == account_id


def unreachable_guest_ids(db: Session, before: datetime, most: int) -> Sequence[UUID]:
    """Some of the guests from before that time whom no browser and no token leads to any more."""
    query = select(Account.id).where(
        Account.role == Role.guest,
        Account.created_at < before,
        ~exists().where(BrowserSession.account_id == Account.id),
        ~exists().where(ApiToken.account_id == Account.id),
    )
    return db.execute(query.limit(most)).scalars().all()


def delete_idle_guests(db: Session, before: datetime, most: int) -> int:
    """Some of the guests from before that time who have sent and answered nothing and are in no class; how many."""
    some = select(Account.id).where(_idle_guest(before)).limit(most).with_for_update(skip_locked=True)
    found = db.execute(some).scalars().all()
    gone = delete(Account).where(Account.id.in_(found), _idle_guest(before)).returning(Account.id)
    return len(db.execute(gone).all())


def count_idle_guests(db: Session, before: datetime) -> int:
    return db.execute(select(func.count()).select_from(Account).where(_idle_guest(before))).scalar_one()


def _idle_guest(before: datetime) -> ColumnElement[bool]:
    return and_(
        Account.role == Role.guest,
        Account.created_at < before,
        ~exists().where(Submission.account_id == Account.id),
        ~exists().where(Membership.account_id == Account.id),
        ~exists().where(PollAnswer.account_id == Account.id),
    )


def inactive_student_ids(db: Session, before: datetime, most: int) -> Sequence[UUID]:
    """Some of the students of whom nothing was heard since, whatever they are in."""
    query = select(Account.id).where(Account.role == Role.student, _silent(before), ~_staff())
    return db.execute(query.order_by(Account.created_at, Account.id).limit(most)).scalars().all()


def departed_student_ids(db: Session, before: datetime, most: int) -> Sequence[UUID]:
    """Some of those whom a class's list has made an account, who had left every class by then, and were silent since.

    A class ends for a student when they leave it, or when it is archived.
    """
    mine = Membership.account_id == Account.id
    made_by_a_list = exists().where(mine, Membership.created_by_list)
    goes_on = or_(
        and_(
            Membership.status != Status.left,
            or_(SchoolClass.archived_at.is_(None), SchoolClass.archived_at >= before),
        ),
        and_(Membership.status == Status.left, Membership.left_at >= before),
    )
    in_a_class = exists().where(mine, SchoolClass.id == Membership.class_id, goes_on)
    query = select(Account.id).where(
        Account.role == Role.student, made_by_a_list, ~in_a_class, _silent(before), ~_staff()
    )
    return db.execute(query.order_by(Account.created_at, Account.id).limit(most)).scalars().all()


def accounts_by_name(db: Session, accounts: Sequence[UUID]) -> Sequence[Account]:
    """These accounts, by their names."""
    query = select(Account).where(Account.id.in_(accounts)).order_by(Account.name, Account.id)
    return db.execute(query).scalars().all()


def _silent(before: datetime) -> ColumnElement[bool]:
    """Nothing was sent, nobody logged in, no token was made or used, and no class was visited since."""
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


def _staff() -> ColumnElement[bool]:
    """Who helps or teaches somewhere is kept, whatever their account is."""
    return exists().where(
        Membership.account_id == Account.id,
        Membership.role.in_((ClassRole.assistant, ClassRole.teacher)),
        Membership.status == Status.active,
    )
