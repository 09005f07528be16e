"""The table of waiting and leased jobs."""

from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import JSON, BigInteger, Index, String, UniqueConstraint
from sqlalchemy.orm import Mapped, mapped_column

from server.database.base import Base, UtcDateTime, utc_now


class Job(Base):
    """Work to do once, outside of any request: `kind` names its task, `key` its subject; lower `priority` runs first.

    `sender`, `address` and `flow` come from `server.queue.interfaces.Sender`; `turn` orders flows of one priority and
    `own_turn` the senders of one flow (`server.queue.fair_queueing`). `required_version` and `refused_at` serve workers
    of several versions (`server.queue.interfaces.WorkerCapabilities`). Only the holder of its lease ends a leased job;
    the row is deleted as the job ends.
    """

    __tablename__ = "job"

    id: Mapped[UUID] = mapped_column(primary_key=True, default=uuid4)
    kind: Mapped[str] = mapped_column(String(32))
    key: Mapped[str] = mapped_column(String(200))
    payload: Mapped[dict[str, Any]] = mapped_column(JSON)
    priority: Mapped[int] = mapped_column(default=0)
    sender: Mapped[str] = mapped_column(String(300))
    address: Mapped[str] = mapped_column(String(300))
    flow: Mapped[str] = mapped_column("line", String(300))
    turn: Mapped[int] = mapped_column(BigInteger)
    own_turn: Mapped[int] = mapped_column(BigInteger)
    created_at: Mapped[datetime] = mapped_column(UtcDateTime, default=utc_now)
    started_at: Mapped[datetime | None] = mapped_column(UtcDateTime)
    required_version: Mapped[str | None] = mapped_column("needs", String(300))
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
