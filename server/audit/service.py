"""Record changes in the transaction that makes them, and read them in batches."""

from collections.abc import Iterator, Mapping
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.audit import repository
from server.audit.models import ABOUT_LENGTH, AuditAction, AuditEvent
from server.audit.schemas import AuditEntry, AuditFilter
from server.database import Database

Values = Mapping[str, Any]
BATCH_SIZE = 500


def record_event(
    db: Session,
    class_id: UUID | None,
    by: UUID | None,
    what: AuditAction,
    *,
    student: UUID | None = None,
    about: str = "",
    before: Values | None = None,
    after: Values | None = None,
    reason: str = "",
) -> None:
    """Add an event of a class, or of the server; `before` and `after` store only their differences.

    Dates are stored in ISO 8601.
    """
    old, new = _plain_values(before or {}), _plain_values(after or {})
    differing = [name for name in {**old, **new} if old.get(name) != new.get(name)]
    event = AuditEvent(
        class_id=class_id,
        by=by,
        what=what,
        student=student,
        about=about[:ABOUT_LENGTH],
        before={name: old[name] for name in differing if name in old},
        after={name: new[name] for name in differing if name in new},
        reason=reason,
    )
    db.add(event)


def _plain_values(values: Values) -> dict[str, Any]:
    return {name: value.isoformat() if isinstance(value, datetime) else value for name, value in values.items()}


def iter_entries(database: Database, class_id: UUID, filters: AuditFilter) -> Iterator[AuditEntry]:
    """Yield all entries, newest first, with a transaction for each batch, so that a slow reader holds none open."""
    last: AuditEntry | None = None
    while True:
        with database.read() as db:
            batch = repository.load_entries(db, class_id, filters, limit=BATCH_SIZE, before=last)
        yield from batch
        if len(batch) < BATCH_SIZE:
            return
        last = batch[-1]
