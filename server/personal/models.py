"""Requests to erase a person's data."""

from datetime import datetime
from uuid import UUID, uuid4

from sqlalchemy import ForeignKey
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class ErasureRequest(Base):
    """A request to erase an account, or with `class_id` what it has in one class.

    It stands until the tests that the account sits or has sat are published. `by_staff`: not by the person themselves.
    `begun_at`: from then on it is carried out, and cannot be cancelled.
    """

    __tablename__ = "erasure_request"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    account_id: Mapped[UUID] = mapped_column(ForeignKey("account.id", ondelete="CASCADE"), index=True)
    class_id: Mapped[UUID | None] = mapped_column(ForeignKey("school_class.id", ondelete="CASCADE"), index=True)
    requested_by: Mapped[UUID | None] = mapped_column(ForeignKey("account.id", ondelete="SET NULL"), index=True)
    by_staff: Mapped[bool]
    requested_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    begun_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
