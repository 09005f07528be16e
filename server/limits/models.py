"""Token buckets, as they are stored."""

from datetime import datetime

from sqlalchemy import String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime


class TokenBucket(Base):
    """The state of one token bucket; `key` says whose and for what (`submit:<account>`, `login:<address>`…)."""

    __tablename__ = "allowance"

    key: Mapped[str] = mapped_column(String(300), primary_key=True)
    tokens: Mapped[float]
    updated_at: Mapped[datetime] = mapped_column(UtcDateTime)
