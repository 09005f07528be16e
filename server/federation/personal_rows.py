"""What the room stores of one person, to take away, and to move to another account of theirs."""

from __future__ import annotations

from collections.abc import Sequence
from uuid import UUID

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.federation.models import ContextTeacher, LineItem, MarkDelivery, ProviderContext, WaitingStudent


def load_sent_marks(db: Session, account_id: UUID) -> Sequence[tuple[MarkDelivery, str]]:
    """Load the marks of an account that a platform has taken, each with the title of its assignment."""
    query = (
        select(MarkDelivery, Assignment.title)
        .join(LineItem, LineItem.id == MarkDelivery.line_item_id)
        .join(Assignment, Assignment.id == LineItem.assignment_id)
        .where(MarkDelivery.account_id == account_id, MarkDelivery.sent_points.is_not(None))
        .order_by(MarkDelivery.sent_at)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def load_courses_taught(db: Session, account_id: UUID) -> Sequence[tuple[ContextTeacher, str]]:
    """Load the courses of platforms that an account teaches, each with its title."""
    query = (
        select(ContextTeacher, ProviderContext.title)
        .join(ProviderContext, ProviderContext.id == ContextTeacher.context_id)
        .where(ContextTeacher.account_id == account_id)
        .order_by(ContextTeacher.seen_at)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def load_awaited_contexts(db: Session, account_id: UUID) -> Sequence[tuple[WaitingStudent, str]]:
    """Load the school classes whose class here an account waits for, each with its title."""
    query = (
        select(WaitingStudent, ProviderContext.title)
        .join(ProviderContext, ProviderContext.id == WaitingStudent.context_id)
        .where(WaitingStudent.account_id == account_id)
        .order_by(WaitingStudent.seen_at)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def move_account_rows(db: Session, newcomer_id: UUID, account_id: UUID) -> None:
    """Move the rows of an account to another one of the same person, which keeps its own where both have one."""
    for table, key in (
        (ContextTeacher, ContextTeacher.context_id),
        (WaitingStudent, WaitingStudent.context_id),
        (MarkDelivery, MarkDelivery.line_item_id),
    ):
        own = select(key).where(table.account_id == account_id)
        db.execute(delete(table).where(table.account_id == newcomer_id, key.in_(own)))
        db.execute(update(table).where(table.account_id == newcomer_id).values(account_id=account_id))
    db.execute(update(ProviderContext).where(ProviderContext.linked_by == newcomer_id).values(linked_by=account_id))
