"""What is counted by processes that nobody reads the figures of."""

from sqlalchemy import BigInteger, String
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base


class EventCount(Base):
    """How often something happened, by its name and by why, in the workers of other machines: of nobody."""

    __tablename__ = "count"

    name: Mapped[str] = mapped_column(String(64), primary_key=True)
    why: Mapped[str] = mapped_column(String(64), primary_key=True)
    times: Mapped[int] = mapped_column(BigInteger)
