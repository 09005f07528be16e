"""Students who have come from a class of their school that no class is tied to yet: a teacher sees who, and ties it.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from server.classes.models import NAME_LENGTH
from server.database import upsert_statement
from server.federation.models import ContextTeacher, IdentityProvider, ProviderContext, WaitingStudent
from server.federation.schemas import SignedPerson
from server.identity.identities import clean_name_or_empty
from server.identity.models import Account


def store_waiting_student(db: Session, context_id: UUID, account_id: UUID, person: SignedPerson, now: datetime) -> None:
    """Store that a student has come from a class of their school."""
    names = {
        "given_name": clean_name_or_empty(person.given_name)[:NAME_LENGTH],
        "family_name": clean_name_or_empty(person.family_name)[:NAME_LENGTH],
        "seen_at": now,
    }
    statement = upsert_statement(db, WaitingStudent).values(context_id=context_id, account_id=account_id, **names)
    db.execute(statement.on_conflict_do_update(index_elements=["context_id", "account_id"], set_=names))


def load_waiting_students(db: Session, context_id: UUID) -> Sequence[tuple[WaitingStudent, Account]]:
    """Load those who wait for a class, in the order of their names."""
    query = (
        select(WaitingStudent, Account)
        .join(Account, Account.id == WaitingStudent.account_id)
        .where(WaitingStudent.context_id == context_id)
        .order_by(WaitingStudent.family_name, WaitingStudent.given_name, Account.name, Account.id)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def delete_waiting_students(db: Session, context_id: UUID, account_id: UUID | None = None) -> None:
    """Forget those who waited, or one of them."""
    statement = delete(WaitingStudent).where(WaitingStudent.context_id == context_id)
    if account_id is not None:
        statement = statement.where(WaitingStudent.account_id == account_id)
    db.execute(statement)


def forget_left_contexts(db: Session, provider_id: UUID, account_id: UUID, contexts: Collection[UUID]) -> None:
    """Forget that an account comes from, or teaches, contexts of a provider that no longer tells so."""
    gone = select(ProviderContext.id).where(
        ProviderContext.provider_id == provider_id, ProviderContext.id.not_in(list(contexts))
    )
    for table in (WaitingStudent, ContextTeacher):
        db.execute(delete(table).where(table.account_id == account_id, table.context_id.in_(gone)))


def load_taught_contexts(db: Session, account_id: UUID) -> Sequence[tuple[ProviderContext, str, int]]:
    """Load the courses and school classes that an account teaches, each with its platform's name and how many wait."""
    waiting = (
        select(func.count())
        .select_from(WaitingStudent)
        .where(WaitingStudent.context_id == ProviderContext.id)
        .scalar_subquery()
    )
    query = (
        select(ProviderContext, IdentityProvider.name, waiting)
        .join(ContextTeacher, ContextTeacher.context_id == ProviderContext.id)
        .join(IdentityProvider, IdentityProvider.id == ProviderContext.provider_id)
        .where(ContextTeacher.account_id == account_id)
        .order_by(IdentityProvider.name, ProviderContext.title, ProviderContext.id)
    )
    return [(row[0], row[1], row[2]) for row in db.execute(query)]
