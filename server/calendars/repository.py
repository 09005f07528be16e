"""Queries on the addresses of calendars."""

from __future__ import annotations

from uuid import UUID

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from server.calendars.models import CalendarAddress
from server.database import upsert_statement, utc_now
from server.identity.models import Account


def find_calendar_address(db: Session, account_id: UUID) -> CalendarAddress | None:
    return db.get(CalendarAddress, account_id)


def save_calendar_address(db: Session, account_id: UUID, token_digest: str) -> None:
    """Store an address, replacing the account's earlier one."""
    row = {"token_digest": token_digest, "created_at": utc_now()}
    statement = upsert_statement(db, CalendarAddress).values(account_id=account_id, **row)
    db.execute(statement.on_conflict_do_update(index_elements=["account_id"], set_=row))


def delete_calendar_address(db: Session, account_id: UUID) -> None:
    db.execute(delete(CalendarAddress).where(CalendarAddress.account_id == account_id))


def find_calendar_owner(db: Session, token_digest: str) -> tuple[CalendarAddress, Account] | None:
    """Return an address with its account, unless the account is disabled."""
    query = select(CalendarAddress, Account).join(Account, Account.id == CalendarAddress.account_id)
    query = query.where(CalendarAddress.token_digest == token_digest, Account.disabled_at.is_(None))
    row = db.execute(query).one_or_none()
    return None if row is None else (row[0], row[1])
