"""Who receives the mails of a class, and the mails to send."""

from datetime import datetime
from enum import StrEnum
from uuid import UUID, uuid4

from sqlalchemy import ForeignKey, Index, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now

ADDRESS_LENGTH, KEY_LENGTH, URL_LENGTH, REASON_LENGTH = 254, 60, 300, 300


class MailSubscription(Base):
    """The address at which an account receives the reviews of a class, once it is confirmed.

    `secret` signs the links of its mails; `service_url` is the service's address as the account asked there.
    """

    __tablename__ = "mail_subscription"
    __table_args__ = (UniqueConstraint("class_id", "account_id"),)

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    class_id: Mapped[UUID] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"))
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    address: Mapped[str] = mapped_column(String(ADDRESS_LENGTH))
    secret: Mapped[str] = mapped_column(String(64))
    service_url: Mapped[str] = mapped_column(String(URL_LENGTH))
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    confirmed_at: Mapped[datetime | None] = mapped_column(UtcDateTime)


class MailState(StrEnum):
    """`waiting`: to be sent, or tried again; `handed`: given to the server, whose answer is awaited; `unknown`: that
    answer was lost; `refused`: given up; `dropped`: there was nothing to tell."""

    waiting = "waiting"
    handed = "handed"
    sent = "sent"
    refused = "refused"
    unknown = "unknown"
    dropped = "dropped"


class MailDelivery(Base):
    """A mail of a subscription; `key` names what it tells: each is sent once at most."""

    __tablename__ = "mail_delivery"
    __table_args__ = (
        UniqueConstraint("subscription_id", "key"),
        Index("ix_mail_delivery_state_next_try_at", "state", "next_try_at"),
    )

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    subscription_id: Mapped[UUID] = mapped_column(ForeignKey("mail_subscription.id", ondelete="CASCADE"))
    key: Mapped[str] = mapped_column(String(KEY_LENGTH))
    state: Mapped[str] = mapped_column(String(8), default=MailState.waiting)
    reason: Mapped[str] = mapped_column(String(REASON_LENGTH), default="")
    tries: Mapped[int] = mapped_column(default=0)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    next_try_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    ended_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
