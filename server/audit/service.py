"""Noting a change, in the transaction that makes it; reading all of them, a few at a time."""

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
AT_ONCE = 500


def record_event(
    db: Session,
    class_id: UUID,
    by: UUID,
    what: AuditAction,
    *,
    student: UUID | None = None,
    about: str = "",
    before: Values | None = None,
    after: Values | None = None,
    reason: str = "",
) -> None:
    """Adds an event; `before` and `after` keep only what differs between them. Dates are kept in ISO 8601."""
    old, new = _plain(before or {}), _plain(after or {})
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


def _plain(values: Values) -> dict[str, Any]:
    return {name: value.isoformat() if isinstance(value, datetime) else value for name, value in values.items()}


def iter_entries(database: Database, class_id: UUID, wanted: AuditFilter) -> Iterator[AuditEntry]:
    """Every event, newest first; a transaction for some hundred, so that a slow reader holds nothing open."""
    last: AuditEntry | None = None
    while True:
        with database.read() as db:
            some = repository.load_entries(db, class_id, wanted, most=AT_ONCE, before=last)
        yield from some
        if len(some) < AT_ONCE:
            return
        last = some[-1]
