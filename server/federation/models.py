"""Providers of identities, their courses, sign-ins that have begun, our keys, and marks to send."""

from datetime import datetime
from enum import StrEnum
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, ForeignKey, String, Text, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now
from server.identity.models import DIGEST_LENGTH, ISSUER_LENGTH

NAME_LENGTH, ID_LENGTH, ADDRESS_LENGTH, REASON_LENGTH = 100, 255, 2000, 300


class Protocol(StrEnum):
    lti = "lti"
    oidc = "oidc"
    cas = "cas"


class IdentityProvider(Base):
    """A system that says who somebody is. `settings` are those of its protocol (`schemas`).

    `trusts_teachers`: who teaches a course there may make classes here. `paused_at`: since when nobody enters by it.
    """

    __tablename__ = "identity_provider"
    __table_args__ = (UniqueConstraint("issuer", "client_id"),)

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    protocol: Mapped[str] = mapped_column(String(8))
    name: Mapped[str] = mapped_column(String(NAME_LENGTH))
    issuer: Mapped[str] = mapped_column(String(ISSUER_LENGTH))
    client_id: Mapped[str] = mapped_column(String(ID_LENGTH))
    settings: Mapped[dict[str, Any]] = mapped_column(JSON)
    trusts_teachers: Mapped[bool] = mapped_column(default=True)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    paused_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


class ActivityKind(StrEnum):
    """What a provider does, or what is asked of it."""

    registration = "registration"
    sign_in = "sign_in"
    keys = "keys"
    roster = "roster"
    content = "content"
    marks = "marks"
    logout = "logout"
    test = "test"


class ProviderActivity(Base):
    """The latest success and the latest failure of each kind. `detail` names nobody."""

    __tablename__ = "provider_activity"

    provider_id: Mapped[UUID] = mapped_column(ForeignKey("identity_provider.id", ondelete="CASCADE"), primary_key=True)
    kind: Mapped[str] = mapped_column(String(16), primary_key=True)
    succeeded: Mapped[bool] = mapped_column(primary_key=True)
    at: Mapped[datetime] = mapped_column(UtcDateTime)
    detail: Mapped[str] = mapped_column(String(REASON_LENGTH), default="")


class RegistrationLink(Base):
    """A one-time address at which a platform registers itself (LTI dynamic registration)."""

    __tablename__ = "registration_link"

    token_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH), primary_key=True)
    created_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime)


class PendingSignIn(Base):
    """A sign-in that a browser has begun: used once, by the same browser, with the same nonce.

    `target` is the page to go to; `details` are the protocol's own.
    """

    __tablename__ = "pending_sign_in"

    state_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH), primary_key=True)
    provider_id: Mapped[UUID] = mapped_column(ForeignKey("identity_provider.id", ondelete="CASCADE"), index=True)
    nonce_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH))
    browser_digest: Mapped[str] = mapped_column(String(DIGEST_LENGTH))
    target: Mapped[str] = mapped_column(String(ADDRESS_LENGTH))
    details: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    expires_at: Mapped[datetime] = mapped_column(UtcDateTime, index=True)


class ProviderContext(Base):
    """A course, or a class, of a provider: tied to a class by a teacher, or not yet.

    `roster_url`, `line_items_url` and `scopes` are those that the latest arrival told, all on the provider's hosts.
    """

    __tablename__ = "provider_context"
    __table_args__ = (UniqueConstraint("provider_id", "deployment", "context"),)

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    provider_id: Mapped[UUID] = mapped_column(ForeignKey("identity_provider.id", ondelete="CASCADE"))
    deployment: Mapped[str] = mapped_column(String(ID_LENGTH), default="")
    context: Mapped[str] = mapped_column(String(ID_LENGTH))
    title: Mapped[str] = mapped_column(String(NAME_LENGTH), default="")
    class_id: Mapped[UUID | None] = mapped_column(ForeignKey("school_class.id", ondelete="SET NULL"), index=True)
    linked_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    roster_url: Mapped[str] = mapped_column(String(ADDRESS_LENGTH), default="")
    line_items_url: Mapped[str] = mapped_column(String(ADDRESS_LENGTH), default="")
    scopes: Mapped[list[str]] = mapped_column(JSON, default=list)
    seen_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class ContextTeacher(Base):
    """An account that has come as a teacher of a context: it may tie the context to a class of its own."""

    __tablename__ = "context_teacher"

    context_id: Mapped[UUID] = mapped_column(ForeignKey("provider_context.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    seen_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class WaitingStudent(Base):
    """An account that has come as a student of a context that no class is tied to; the class that is tied takes it in.

    The names are those that the provider tells, and may be empty.
    """

    __tablename__ = "waiting_student"

    context_id: Mapped[UUID] = mapped_column(ForeignKey("provider_context.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    given_name: Mapped[str] = mapped_column(String(NAME_LENGTH), default="")
    family_name: Mapped[str] = mapped_column(String(NAME_LENGTH), default="")
    seen_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class LineItem(Base):
    """A column of a platform's gradebook for an assignment: one for each context. `url` None: not found or made yet.

    `problem` says why nothing can be sent; `check_at` is when the gradebook is next compared.
    """

    __tablename__ = "line_item"
    __table_args__ = (UniqueConstraint("context_id", "assignment_id"),)

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    context_id: Mapped[UUID] = mapped_column(ForeignKey("provider_context.id", ondelete="CASCADE"))
    assignment_id: Mapped[UUID] = mapped_column(ForeignKey("assignment.id", ondelete="CASCADE"), index=True)
    url: Mapped[str | None] = mapped_column(String(ADDRESS_LENGTH))
    problem: Mapped[str] = mapped_column(String(REASON_LENGTH), default="")
    check_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class DeliveryState(StrEnum):
    """`waiting`: to be sent, or sent without an answer; `refused`: until somebody sends it again, or it changes."""

    waiting = "waiting"
    sent = "sent"
    refused = "refused"


class MarkDelivery(Base):
    """A student's mark for a line item, in points out of 20: the one to send, and the one that the platform has taken.

    `told_at` is the latest timestamp that was sent, whatever came of it: the next one is later by a second at least.
    """

    __tablename__ = "mark_delivery"

    line_item_id: Mapped[UUID] = mapped_column(ForeignKey("line_item.id", ondelete="CASCADE"), primary_key=True)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), primary_key=True, index=True)
    points: Mapped[float]
    sent_points: Mapped[float | None]
    state: Mapped[str] = mapped_column(String(8), default=DeliveryState.waiting)
    reason: Mapped[str] = mapped_column(String(REASON_LENGTH), default="")
    tries: Mapped[int] = mapped_column(default=0)
    told_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    sent_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    next_try_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)


class SigningKey(Base):
    """A private key of ours, in PEM. It signs once platforms have had time to fetch it; all are published."""

    __tablename__ = "signing_key"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    private_pem: Mapped[str] = mapped_column(Text)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
