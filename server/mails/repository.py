"""Queries on who receives mails, and on the mails to send."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID, uuid4

from sqlalchemy import and_, delete, func, or_, select
from sqlalchemy.orm import Session

from server.classes.models import SchoolClass
from server.database import upsert_statement
from server.identity.models import Account
from server.mails.models import MailDelivery, MailState, MailSubscription


def find_subscription(db: Session, class_id: UUID, account_id: UUID) -> MailSubscription | None:
    query = select(MailSubscription).where(
        MailSubscription.class_id == class_id, MailSubscription.account_id == account_id
    )
    return db.execute(query).scalar_one_or_none()


def find_subscription_with_class(db: Session, subscription_id: UUID) -> tuple[MailSubscription, SchoolClass] | None:
    query = select(MailSubscription, SchoolClass).join(SchoolClass, SchoolClass.id == MailSubscription.class_id)
    row = db.execute(query.where(MailSubscription.id == subscription_id)).one_or_none()
    return None if row is None else (row[0], row[1])


def load_account_subscriptions(db: Session, account_id: UUID) -> Sequence[tuple[MailSubscription, str]]:
    """Load an account's subscriptions, each with the name of its class."""
    query = select(MailSubscription, SchoolClass.name).join(SchoolClass, SchoolClass.id == MailSubscription.class_id)
    query = query.where(MailSubscription.account_id == account_id).order_by(MailSubscription.created_at)
    return [(row[0], row[1]) for row in db.execute(query)]


def load_confirmed_subscriptions(db: Session) -> Sequence[tuple[MailSubscription, datetime]]:
    """Load the subscriptions of open classes to confirmed addresses, each with when it was confirmed."""
    query = (
        select(MailSubscription)
        .join(SchoolClass, SchoolClass.id == MailSubscription.class_id)
        .where(MailSubscription.confirmed_at.is_not(None), SchoolClass.archived_at.is_(None))
        .order_by(MailSubscription.created_at)
    )
    return [(row, row.confirmed_at) for row in db.execute(query).scalars() if row.confirmed_at is not None]


def load_queued_mail_keys(db: Session, subscription_ids: Collection[UUID]) -> set[tuple[UUID, str]]:
    """Load subscription and key of their mails, whatever came of these."""
    query = select(MailDelivery.subscription_id, MailDelivery.key)
    return {(row[0], row[1]) for row in db.execute(query.where(MailDelivery.subscription_id.in_(subscription_ids)))}


def has_due_mail(db: Session, now: datetime, handed_before: datetime) -> bool:
    """Whether a mail is due, or was handed over by a process of which nothing more is heard."""
    due = and_(MailDelivery.state == MailState.waiting, MailDelivery.next_try_at <= now)
    lost = and_(MailDelivery.state == MailState.handed, MailDelivery.next_try_at <= handed_before)
    return db.execute(select(MailDelivery.id).where(or_(due, lost)).limit(1)).first() is not None


def delete_subscription(db: Session, subscription_id: UUID) -> None:
    db.execute(delete(MailSubscription).where(MailSubscription.id == subscription_id))


def lock_subscription(db: Session, subscription_id: UUID) -> MailSubscription | None:
    return db.get(MailSubscription, subscription_id, with_for_update=True)


def add_delivery(db: Session, subscription_id: UUID, key: str, now: datetime) -> None:
    """Add a mail to send, unless that subscription has had one of this key."""
    statement = upsert_statement(db, MailDelivery).values(
        id=uuid4(), subscription_id=subscription_id, key=key, state=MailState.waiting, reason="", tries=0,
        created_at=now, next_try_at=now,
    )  # fmt: skip
    db.execute(statement.on_conflict_do_nothing(index_elements=["subscription_id", "key"]))


def lock_next_due_delivery(db: Session, now: datetime) -> tuple[MailDelivery, MailSubscription, Account] | None:
    """Lock and return the mail that is due for the longest time; the mails that another process has locked are its."""
    query = (
        select(MailDelivery, MailSubscription, Account)
        .join(MailSubscription, MailSubscription.id == MailDelivery.subscription_id)
        .join(Account, Account.id == MailSubscription.account_id)
        .where(MailDelivery.state == MailState.waiting, MailDelivery.next_try_at <= now)
        .order_by(MailDelivery.next_try_at, MailDelivery.id)
        .limit(1)
        .with_for_update(of=MailDelivery, skip_locked=True)
    )
    row = db.execute(query).one_or_none()
    return None if row is None else (row[0], row[1], row[2])


def lock_delivery(db: Session, delivery_id: UUID) -> MailDelivery | None:
    return db.get(MailDelivery, delivery_id, with_for_update=True, populate_existing=True)


def load_deliveries_handed_before(db: Session, before: datetime) -> Sequence[MailDelivery]:
    """Load mails that were handed over, and of whose process nothing more is heard."""
    query = select(MailDelivery).where(MailDelivery.state == MailState.handed, MailDelivery.next_try_at <= before)
    return db.execute(query.with_for_update(skip_locked=True)).scalars().all()


def find_latest_delivery(db: Session, subscription_id: UUID) -> MailDelivery | None:
    """Return the latest mail that had something to tell: a Monday without news hides no lost mail."""
    query = select(MailDelivery).where(
        MailDelivery.subscription_id == subscription_id, MailDelivery.state != MailState.dropped
    )
    return db.execute(query.order_by(MailDelivery.created_at.desc(), MailDelivery.id).limit(1)).scalar_one_or_none()


def count_deliveries_by_state(db: Session, since: datetime) -> Mapping[str, int]:
    query = select(MailDelivery.state, func.count()).where(MailDelivery.created_at >= since)
    return {row[0]: row[1] for row in db.execute(query.group_by(MailDelivery.state))}


def load_delivery_problems(db: Session, since: datetime, limit: int) -> Sequence[tuple[MailDelivery, str]]:
    """Load the latest mails that were refused, lost or are tried again, each with the name of its class."""
    query = (
        select(MailDelivery, SchoolClass.name)
        .join(MailSubscription, MailSubscription.id == MailDelivery.subscription_id)
        .join(SchoolClass, SchoolClass.id == MailSubscription.class_id)
        .where(MailDelivery.created_at >= since, MailDelivery.reason != "")
        .order_by(MailDelivery.created_at.desc(), MailDelivery.id)
        .limit(limit)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def delete_old_mails(db: Session, deliveries_before: datetime, unconfirmed_before: datetime) -> None:
    """Delete old mails, and requests for mails that nobody has confirmed."""
    db.execute(delete(MailDelivery).where(MailDelivery.created_at < deliveries_before))
    old = MailSubscription.confirmed_at.is_(None) & (MailSubscription.created_at < unconfirmed_before)
    db.execute(delete(MailSubscription).where(old))
