"""Queries on line items, and on the marks that are sent to them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from uuid import UUID, uuid4

from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.classes.models import SchoolClass
from server.database import upsert_statement
from server.federation.models import DeliveryState, IdentityProvider, LineItem, MarkDelivery, ProviderContext
from server.identity.models import FederatedIdentity


def load_line_items(db: Session, context_id: UUID) -> Sequence[tuple[LineItem, Assignment]]:
    """Load the line items of a context whose assignments are not removed, in the order of the assignments."""
    query = (
        select(LineItem, Assignment)
        .join(Assignment, Assignment.id == LineItem.assignment_id)
        .where(LineItem.context_id == context_id, Assignment.removed_at.is_(None))
        .order_by(Assignment.opens_at, Assignment.id)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def find_line_item(db: Session, context_id: UUID, assignment_id: UUID) -> LineItem | None:
    query = select(LineItem).where(LineItem.context_id == context_id, LineItem.assignment_id == assignment_id)
    return db.execute(query).scalar_one_or_none()


def add_line_item(db: Session, context_id: UUID, assignment_id: UUID, now: datetime) -> None:
    """Add a line item, unless there is one; its gradebook is compared at once."""
    statement = upsert_statement(db, LineItem).values(
        id=uuid4(), context_id=context_id, assignment_id=assignment_id, problem="", check_at=now, created_at=now
    )
    db.execute(statement.on_conflict_do_update(index_elements=["context_id", "assignment_id"], set_={"check_at": now}))


def take_due_contexts(db: Session, now: datetime, next_check: datetime) -> Sequence[UUID]:
    """Return the contexts with line items to compare, and put their next comparison off, in one statement: one process
    takes each."""
    open_contexts = (
        select(ProviderContext.id)
        .join(SchoolClass, SchoolClass.id == ProviderContext.class_id)
        .join(IdentityProvider, IdentityProvider.id == ProviderContext.provider_id)
        .where(IdentityProvider.paused_at.is_(None))
    )
    statement = (
        update(LineItem)
        .where(LineItem.check_at <= now, LineItem.context_id.in_(open_contexts))
        .values(check_at=next_check)
        .returning(LineItem.context_id)
        .execution_options(synchronize_session=False)
    )
    return sorted(set(db.execute(statement).scalars()))


def load_deliveries(db: Session, line_item_ids: Collection[UUID]) -> Mapping[tuple[UUID, UUID], MarkDelivery]:
    query = select(MarkDelivery).where(MarkDelivery.line_item_id.in_(line_item_ids))
    return {(row.line_item_id, row.account_id): row for row in db.execute(query).scalars()}


def load_due_deliveries(
    db: Session, line_item_ids: Collection[UUID], issuer: str, now: datetime, limit: int
) -> Sequence[tuple[MarkDelivery, str]]:
    """Load deliveries that wait and are due, each with its account's subject."""
    query = (
        select(MarkDelivery, FederatedIdentity.subject)
        .join(FederatedIdentity, FederatedIdentity.account_id == MarkDelivery.account_id)
        .where(
            MarkDelivery.line_item_id.in_(line_item_ids),
            MarkDelivery.state == DeliveryState.waiting,
            MarkDelivery.next_try_at <= now,
            FederatedIdentity.issuer == issuer,
        )
        .order_by(MarkDelivery.next_try_at, MarkDelivery.account_id)
        .limit(limit)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def find_next_try(db: Session, line_item_ids: Collection[UUID]) -> datetime | None:
    """Return when the next delivery that waits is due."""
    query = select(func.min(MarkDelivery.next_try_at)).where(
        MarkDelivery.line_item_id.in_(line_item_ids), MarkDelivery.state == DeliveryState.waiting
    )
    return db.execute(query).scalar_one_or_none()


def requeue_deliveries(db: Session, line_item_ids: Collection[UUID], account_id: UUID | None, now: datetime) -> int:
    """Have refused deliveries and those that wait sent again at once, or that of one account whatever its state; return
    how many."""
    is_chosen = (
        MarkDelivery.state != DeliveryState.sent if account_id is None else MarkDelivery.account_id == account_id
    )
    statement = (
        update(MarkDelivery)
        .where(MarkDelivery.line_item_id.in_(line_item_ids), is_chosen)
        .values(state=DeliveryState.waiting, reason="", tries=0, next_try_at=now)
        .returning(MarkDelivery.account_id)
        .execution_options(synchronize_session=False)
    )
    db.execute(update(LineItem).where(LineItem.id.in_(line_item_ids)).values(problem="", check_at=now))
    return len(db.execute(statement).all())


def find_delivery(db: Session, line_item_id: UUID, account_id: UUID) -> MarkDelivery | None:
    return db.get(MarkDelivery, (line_item_id, account_id), with_for_update=True, populate_existing=True)


def load_line_items_to_send(db: Session, line_item_ids: Collection[UUID]) -> Collection[UUID]:
    """Return those of these line items that have a mark to send."""
    query = select(MarkDelivery.line_item_id).where(
        MarkDelivery.line_item_id.in_(line_item_ids), MarkDelivery.state == DeliveryState.waiting
    )
    return set(db.execute(query.distinct()).scalars())


def set_line_item(db: Session, line_item_id: UUID, url: str | None, problem: str) -> None:
    db.execute(update(LineItem).where(LineItem.id == line_item_id).values(url=url, problem=problem))


def set_missing_line_item_url(db: Session, context_id: UUID, assignment_id: UUID, url: str, now: datetime) -> None:
    """Set the address of a line item that has none, and have its marks sent."""
    statement = update(LineItem).where(
        LineItem.context_id == context_id, LineItem.assignment_id == assignment_id, LineItem.url.is_(None)
    )
    db.execute(statement.values(url=url, problem="", check_at=now))


def remove_line_item(db: Session, context_id: UUID, assignment_id: UUID) -> None:
    """Send no more marks of an assignment; those that were sent stay on the platform."""
    db.execute(delete(LineItem).where(LineItem.context_id == context_id, LineItem.assignment_id == assignment_id))


def set_next_comparison(db: Session, context_id: UUID, at: datetime) -> None:
    """Compare a course's marks next then."""
    db.execute(update(LineItem).where(LineItem.context_id == context_id).values(check_at=at))


def has_due_line_items(db: Session, now: datetime) -> bool:
    return db.execute(select(LineItem.id).where(LineItem.check_at <= now).limit(1)).first() is not None
