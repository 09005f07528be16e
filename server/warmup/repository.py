"""Queries on warm-ups, and on the answers to them."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date
from typing import Any
from uuid import UUID

from sqlalchemy import select
from sqlalchemy.orm import Session

from server.database import upsert_statement
from server.warmup.models import WarmUp


def find_warm_up(db: Session, class_id: UUID, day: date) -> WarmUp | None:
    query = select(WarmUp).where(WarmUp.class_id == class_id, WarmUp.day == day)
    return db.execute(query).scalar_one_or_none()


def add_warm_up_if_absent(db: Session, class_id: UUID, day: date, questions: Sequence[dict[str, Any]]) -> None:
    """Store the questions of a day, unless there are some already: of two requests at once, the first one's stay."""
    statement = upsert_statement(db, WarmUp).values(class_id=class_id, day=day, questions=list(questions))
    db.execute(statement.on_conflict_do_nothing())
