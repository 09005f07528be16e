"""A job, from its putting to its end."""

from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, BigInteger, Index, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class Job(Base):
    """Work to be done once, outside of any request. `kind` says by whom, `key` on what; lower `priority` runs first.

    `sender`, `address` and `line` are `server.queue.port.Sender`'s; `turn` is the line's among those of its priority,
    and `own_turn` the sender's within the line (`server.queue.turns`). `needs` and `refused_at` are of workers of
    several versions (see `server.queue.port.Able`). While it is leased, only the lease's holder may end it. The row
    goes with the job's end.
    """

    __tablename__ = "job"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    kind: Mapped[str] = mapped_column(String(32))
    key: Mapped[str] = mapped_column(String(200))
    payload: Mapped[dict[str, Any]] = mapped_column(JSON)
    priority: Mapped[int] = mapped_column(default=0)
    sender: Mapped[str] = mapped_column(String(300))
    address: Mapped[str] = mapped_column(String(300))
    line: Mapped[str] = mapped_column(String(300))
    turn: Mapped[int] = mapped_column(BigInteger)
    own_turn: Mapped[int] = mapped_column(BigInteger)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    started_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    needs: Mapped[str | None] = mapped_column(String(300))
    refused_at: Mapped[datetime | None] = mapped_column(UtcDateTime)

    tries: Mapped[int] = mapped_column(default=0)
    lease_owner: Mapped[str | None] = mapped_column(String(300))
    lease_token: Mapped[UUID | None]
    lease_until: Mapped[datetime | None] = mapped_column(UtcDateTime)

    #: The key before the kind: SQLite would otherwise find the next job by its kind, and sort all that wait.
    __table_args__ = (UniqueConstraint("key", "kind"), Index("ix_job_line", "line"))


_WAITS, _LEASED = Job.lease_token.is_(None), Job.lease_token.is_not(None)
_order = (Job.priority, Job.turn, Job.created_at, Job.id)
Index("ix_job_claim", *_order, sqlite_where=_WAITS, postgresql_where=_WAITS)
Index("ix_job_leased", Job.priority, Job.turn, sqlite_where=_LEASED, postgresql_where=_LEASED)
Index("ix_job_address", Job.address, Job.priority, sqlite_where=_WAITS, postgresql_where=_WAITS)
