"""Counters of events."""

from sqlalchemy import BigInteger, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base


class EventCount(Base):
    """How often an event happened on workers of other machines, by name and reason."""

    __tablename__ = "count"

    name: Mapped[str] = mapped_column(String(64), primary_key=True)
    why: Mapped[str] = mapped_column(String(64), primary_key=True)
    times: Mapped[int] = mapped_column(BigInteger)
