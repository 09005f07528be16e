"""How a teacher said that the columns of a list are read, remembered for the next file with the same headers."""

from __future__ import annotations

from dataclasses import replace
from uuid import UUID

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from server.classes.columns import find_header
from server.classes.models import RememberedColumns
from server.classes.roster import ReadingChoice, Roster, header_signatures
from server.classes.sheets import SheetReading
from server.database import utc_now

MAX_READINGS = 20  # of a teacher


def apply_remembered_columns(
    db: Session, account_id: UUID, source: SheetReading, choice: ReadingChoice
) -> ReadingChoice:
    """Return the choice with the columns that this teacher said for these headers before, where they said any."""
    lines = header_signatures(source.rows)
    query = select(RememberedColumns).where(
        RememberedColumns.account_id == account_id, RememberedColumns.signature.in_(lines)
    )
    reading = db.execute(query.order_by(RememberedColumns.used_at.desc()).limit(1)).scalar_one_or_none()
    if reading is None or choice.columns:
        return choice
    return replace(choice, columns=tuple(reading.columns), first_line=lines[reading.signature])


def remember_columns(db: Session, account_id: UUID, roster: Roster, choice: ReadingChoice) -> None:
    """Remember the columns that a teacher said by hand; forget them where they are what the headers say."""
    rows = roster.header.rows
    if not choice.columns or not rows:
        return
    line = roster.rows[rows].line if rows < len(roster.rows) else 0
    signature = next((each for each, after in header_signatures(roster.rows).items() if after == line), None)
    if signature is None:
        return
    stored = db.get(RememberedColumns, (account_id, signature))
    found = find_header(roster.rows)
    if found and not found.doubt and tuple(column.field or "" for column in found.columns) == choice.columns:
        if stored:
            db.delete(stored)
        return
    if stored is None:
        db.add(stored := RememberedColumns(account_id=account_id, signature=signature))
    stored.columns, stored.used_at = list(choice.columns), utc_now()
    db.flush()
    query = select(RememberedColumns.signature).where(RememberedColumns.account_id == account_id)
    oldest = db.execute(query.order_by(RememberedColumns.used_at.desc()).offset(MAX_READINGS)).scalars().all()
    if oldest:
        own = RememberedColumns.account_id == account_id
        db.execute(delete(RememberedColumns).where(own, RememberedColumns.signature.in_(oldest)))
