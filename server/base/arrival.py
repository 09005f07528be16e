"""The arrival of a request: when its whole body has reached the server, before it waits for a thread or a database.

What counts for dates is the arrival: a busy server makes nobody late.
"""

from __future__ import annotations

from contextvars import ContextVar
from datetime import UTC, datetime

_arrival: ContextVar[datetime | None] = ContextVar("arrival", default=None)


def record_arrival() -> None:
    _arrival.set(datetime.now(UTC))


def arrival_time() -> datetime:
    """Return when the request that is being served arrived; now, outside of a request that changes something."""
    return _arrival.get() or datetime.now(UTC)
