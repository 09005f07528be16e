"""Where an assignment stands, for somebody whose rules are known: pure."""

from __future__ import annotations

from datetime import datetime
from enum import StrEnum

from server.assignments.rules import Rules


class Stage(StrEnum):
    """`late`: past the due date, and what is sent still counts."""

    upcoming = "upcoming"
    open = "open"
    late = "late"
    closed = "closed"


def stage(rules: Rules, now: datetime) -> Stage:
    if now < rules.opens_at:
        return Stage.upcoming
    if rules.last_moment is not None and now > rules.last_moment:
        return Stage.closed
    return Stage.late if rules.due_at is not None and now > rules.due_at else Stage.open
