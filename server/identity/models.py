"""Accounts and their credentials. Secrets are stored hashed only."""

from datetime import datetime
from enum import StrEnum
from uuid import UUID, uuid4

from sqlalchemy import ForeignKey, String, UniqueConstraint, false
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

DIGEST_LENGTH = 64
GUEST_HANDLE = "invité"
ISSUER_LENGTH, SUBJECT_LENGTH, FRAMES_LENGTH = 500, 255, 1000


class Role(StrEnum):
    """The role of an account on the server. A teacher creates classes; an administrator manages everything."""

    guest = "guest"
    student = "student"
    teacher = "teacher"
    administrator = "administrator"


def account_handle(login: str | None, role: str, account_id: UUID) -> str:
    return login or (GUEST_HANDLE if role == Role.guest else f"compte {account_id.hex[:6]}")


class Account(Base):
    """An account. A guest is one by its role, whatever its credentials: it has only the browser's session.

    Its credentials are a login with a password, and identities in other systems (`FederatedIdentity`): either may be
    missing. `has_pseudonym`: no name is known for it, so that `name` is one of ours, which its owner may word.
    """

    __tablename__ = "account"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    role: Mapped[str] = mapped_column(String(16), default=Role.guest)
    name: Mapped[str] = mapped_column(String(100))
    login: Mapped[str | None] = mapped_column(String(254), unique=True)
    password_hash: Mapped[str | None] = mapped_column(String(255))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    #: Since when nobody can log in; the work stays.
    disabled_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    has_pseudonym: Mapped[bool] = mapped_column(default=False, server_default=false())

    @property
    def is_guest(self) -> bool:
        return self.role == Role.guest

    @property
    def handle(self) -> str:
        """A short text that tells the account from its namesakes: its login, else « invité », else some of its id."""
        return account_handle(self.login, self.role, self.id)

    @property
    def is_teacher(self) -> bool:
        return self.role in {Role.teacher, Role.administrator}

    @property
    def is_administrator(self) -> bool:
        return self.role == Role.administrator


class FederatedIdentity(Base):
    """An account's identity in another system: `subject` is unique for an `issuer`, and neither is an e-mail address.

    It is a credential beside the password. It ends with its account, and never moves to another one by itself.
    """

    __tablename__ = "federated_identity"
    __table_args__ = (UniqueConstraint("issuer", "subject"),)

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    issuer: Mapped[str] = mapped_column(String(ISSUER_LENGTH))
    subject: Mapped[str] = mapped_column(String(SUBJECT_LENGTH))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    #: The latest sign-in; None where a list of the other system has named the person, who never came.
    seen_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


class BrowserSession(Base):
    """A session of a browser. `identity_id` is the identity that opened it, None for a password or a guest.

    `external_digest` is the digest of the session's name in the system that opened it, by which that system ends it.
    `frames` are the origins, separated by spaces, whose pages may show it in a frame; empty for none.
    """

    __tablename__ = "browser_session"

    token_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)
    identity_id: Mapped[UUID | None] = mapped_column(
        ForeignKey("federated_identity.id", ondelete="CASCADE"), index=True
    )
    external_digest: Mapped[str | None] = mapped_column(String(DIGEST_LENGTH), index=True)
    frames: Mapped[str] = mapped_column(String(FRAMES_LENGTH), default="")


class KnownDevice(Base):
    """A browser in which an account has logged in: wrong passwords from elsewhere do not use up its log-in attempts."""

    __tablename__ = "known_device"

    token_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    seen_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class ApiToken(Base):
    __tablename__ = "api_token"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    label: Mapped[str] = mapped_column(String(100))
    token_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH), unique=True)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)
    last_used_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


class PasswordLink(Base):
    """A one-time link by which the account's owner chooses a new password: one at most for each account.

    It ends when the account's role is no longer `role`. The link of a slip has the class of the slip and the teacher
    who made it, and ends when they could make it no longer (`server.rights.slips`); its token is the short `code`, kept
    as it is until it is used, so that the slips can be shown again. That of an administrator has
    neither.
    """

    __tablename__ = "password_link"

    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True)
    role: Mapped[str] = mapped_column(String(16))
    class_id: Mapped[UUID | None]
    made_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    token_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH), unique=True)
    code: Mapped[str | None] = mapped_column(String(8))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)


class Invitation(Base):
    """A one-time link that gives `role` to whoever opens it first; without `expires_at`, however late."""

    __tablename__ = "invitation"

    token_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH), primary_key=True)
    role: Mapped[str] = mapped_column(String(16))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    expires_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    used_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
