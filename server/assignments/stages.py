"""The stage of an assignment by a student's rules. Pure."""

from __future__ import annotations

from datetime import datetime
from enum import StrEnum

from server.assignments.rules import Rules


class AssignmentStage(StrEnum):
    """`late`: past the due date, while attempts still count."""

    upcoming = "upcoming"
    open = "open"
    late = "late"
    closed = "closed"


def assignment_stage(rules: Rules, now: datetime) -> AssignmentStage:
    if now < rules.opens_at:
        return AssignmentStage.upcoming
    if rules.latest_counting_time is not None and now > rules.latest_counting_time:
        return AssignmentStage.closed
    return AssignmentStage.late if rules.due_at is not None and now > rules.due_at else AssignmentStage.open
