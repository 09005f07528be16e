"""Queries on accounts, browser sessions, API tokens and invitations."""

from collections.abc import Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import delete, select, update
from sqlalchemy.orm import Session

from server.identity.models import Account, ApiToken, BrowserSession, Invitation, Role


def by_id(db: Session, account_id: UUID) -> Account | None:
    return db.get(Account, account_id)


def by_login(db: Session, login: str) -> Account | None:
    return db.execute(select(Account).where(Account.login == login)).scalar_one_or_none()


def by_session(db: Session, token_digest: str, now: datetime) -> Account | None:
    query = (
        select(Account)
        .join(BrowserSession, BrowserSession.account_id == Account.id)
        .where(BrowserSession.token_digest == token_digest, BrowserSession.expires_at > now)
    )
    return db.execute(query).scalar_one_or_none()


def by_api_token(db: Session, token_digest: str) -> Account | None:
    query = (
        select(Account).join(ApiToken, ApiToken.account_id == Account.id).where(ApiToken.token_digest == token_digest)
    )
    return db.execute(query).scalar_one_or_none()


def delete_ended_sessions(db: Session, now: datetime) -> None:
    db.execute(delete(BrowserSession).where(BrowserSession.expires_at < now))


def teacher_exists(db: Session) -> bool:
    return db.execute(select(Account.id).where(Account.role == Role.teacher).limit(1)).first() is not None


def delete_session(db: Session, token_digest: str) -> None:
    db.execute(delete(BrowserSession).where(BrowserSession.token_digest == token_digest))


def delete_sessions_of(db: Session, account_id: UUID) -> None:
    db.execute(delete(BrowserSession).where(BrowserSession.account_id == account_id))


def delete_account(db: Session, account_id: UUID) -> None:
    db.execute(delete(Account).where(Account.id == account_id))


def tokens_of(db: Session, account_id: UUID) -> Sequence[ApiToken]:
    query = select(ApiToken).where(ApiToken.account_id == account_id).order_by(ApiToken.created_at)
    return db.execute(query).scalars().all()


def delete_token(db: Session, account_id: UUID, token_id: UUID) -> bool:
    statement = (
        delete(ApiToken).where(ApiToken.id == token_id, ApiToken.account_id == account_id).returning(ApiToken.id)
    )
    return db.execute(statement).first() is not None


def delete_unused_invitations(db: Session, role: Role) -> None:
    db.execute(delete(Invitation).where(Invitation.role == role, Invitation.used_at.is_(None)))


def open_invitation(db: Session, token_digest: str) -> Invitation | None:
    query = select(Invitation).where(Invitation.token_digest == token_digest, Invitation.used_at.is_(None))
    return db.execute(query).scalar_one_or_none()


def use_invitation(db: Session, token_digest: str, now: datetime) -> Role | None:
    """Marks the invitation as used, in one conditional statement: of two simultaneous uses one only gets the role."""
    statement = (
        update(Invitation)
        .where(Invitation.token_digest == token_digest, Invitation.used_at.is_(None))
        .values(used_at=now)
        .returning(Invitation.role)
    )
    role = db.execute(statement).scalar_one_or_none()
    return None if role is None else Role(role)
