"""A person's marks as plain values: what teachers set and typed, and the logs of their classes."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import team_repository
from server.assignments.models import Assignment
from server.audit import repository as audit
from server.audit.models import AuditAction, AuditEvent
from server.database import utc_now
from server.gradebook import service as gradebook
from server.mails import repository as mails
from server.marks import columns_repository, rubrics_repository
from server.marks import repository as marks
from server.marks.models import ManualColumn, ManualMark, Override, Rubric, RubricMarking, StateDecision
from server.marks.rubric_items import OVERALL
from server.marks.schemas import is_test_withheld

#: Their reason is for the staff alone: who may read it is asked of the school.
PRIVATE = frozenset({AuditAction.exemption_made, AuditAction.exemption_revoked})
#: Their column may not be published: the marks of those that are stand under `columns`.
UNTOLD = frozenset({AuditAction.column_mark_changed})
OF_MARKS = frozenset(
    {
        AuditAction.mark_overridden,
        AuditAction.override_withdrawn,
        AuditAction.state_decided,
        AuditAction.decision_withdrawn,
        AuditAction.regrade_applied,
        AuditAction.regrade_undone,
    }
)


def marks_data(db: Session, account_id: UUID) -> dict[str, Any]:
    """Events say in words what they are about: while a test holds anything, none is told of any mark from then on."""
    held = gradebook.load_withholding_times(db, account_id)
    since = min(held.values(), default=None)
    about = [
        {**_event_data(event, name), "reason": _event_reason(event)}
        for event, name in audit.load_events_about(db, account_id)
        if event.what not in UNTOLD and (since is None or event.at < since or event.what not in OF_MARKS)
    ]
    by = [{**_event_data(event, name), "reason": event.reason} for event, name in audit.load_events_by(db, account_id)]
    return {
        "overrides": [
            _override_data(override, name)
            for override, name in marks.load_overrides_on_account(db, account_id)
            if override.exercise not in held or override.at < held[override.exercise]
        ],
        "decisions": [
            _decision_data(decision, assignment, name)
            for decision, assignment, name in marks.load_decisions_about_account(db, account_id)
            if not is_test_withheld(assignment, utc_now())
        ],
        "columns": [
            _column_mark_data(mark, column, name)
            for mark, column, name in columns_repository.load_account_marks(db, account_id)
            if column.published_at is not None and column.deleted_at is None
        ],
        "copies_marked_by_hand": [
            _rubric_marking_data(marking, rubric, column, name)
            for marking, rubric, column, name in rubrics_repository.load_account_markings(db, account_id)
            if column.published_at is not None and column.deleted_at is None and marking.finished_at is not None
        ],
        "overrides_you_set": [
            _override_data(override, name) for override, name in marks.load_overrides_by_author(db, account_id)
        ],
        "changes_about_you": about,
        "changes_you_made": by,
    }


def teams_data(db: Session, account_id: UUID) -> dict[str, Any]:
    """Return with which assignments, and when, a person handed in with others, who are not named; and proposals."""
    return {
        "teams": [
            {
                "class": name,
                "assignment": assignment.title,
                "since": format_time(place.since),
                "until": format_time(place.until),
            }
            for place, assignment, name in team_repository.load_team_history(db, account_id)
        ],
        "team_proposals": [
            {"assignment": title, "by_you": row.account_id == account_id, "at": format_time(row.proposed_at)}
            for row, title in team_repository.load_account_proposals(db, account_id)
        ],
    }


def _override_data(override: Override, name: str) -> dict[str, Any]:
    return {
        "class": name,
        "exercise": override.exercise,
        "assignment": None if override.assignment_id is None else str(override.assignment_id),
        "points": override.points,
        "excused": override.excused,
        "reason": override.reason,
        "at": format_time(override.at),
        "withdrawn_at": format_time(override.withdrawn_at),
    }


def _decision_data(decision: StateDecision, assignment: Assignment, name: str) -> dict[str, Any]:
    return {
        "class": name,
        "assignment": assignment.title,
        "state": decision.state,
        "reason": decision.reason,
        "at": format_time(decision.at),
        "withdrawn_at": format_time(decision.withdrawn_at),
    }


def _column_mark_data(mark: ManualMark, column: ManualColumn, name: str) -> dict[str, Any]:
    return {
        "class": name,
        "column": column.title,
        "out_of": column.out_of,
        "taken_on": None if column.taken_on is None else column.taken_on.isoformat(),
        "points": mark.points,
        "state": mark.state,
        "comment": mark.comment,
        "at": format_time(mark.at),
    }


def _rubric_marking_data(marking: RubricMarking, rubric: Rubric, column: ManualColumn, name: str) -> dict[str, Any]:
    given = rubrics_repository.read_rubric_scores(marking)
    return {
        "class": name,
        "column": column.title,
        "criteria": [
            {
                "title": item.title,
                "out_of": item.points,
                "points": given.points.get(item.id),
                "remark": given.remarks.get(item.id, ""),
            }
            for item in rubrics_repository.read_rubric_items(rubric)
        ],
        "remark": given.remarks.get(OVERALL, ""),
        "at": format_time(marking.at),
    }


def _event_data(event: AuditEvent, name: str | None) -> dict[str, Any]:
    change = {"what": event.what, "about": event.about, "before": event.before, "after": event.after}
    return {"class": name, "at": format_time(event.at), **change}


def _event_reason(event: AuditEvent) -> str:
    return "" if event.what in PRIVATE else event.reason


def format_time(when: datetime | None) -> str | None:
    return None if when is None else when.isoformat()


def iter_mail_data(db: Session, account_id: UUID) -> Iterator[dict[str, Any]]:
    """Yield the addresses to which an account has mails sent."""
    for row, name in mails.load_account_subscriptions(db, account_id):
        asked, confirmed = format_time(row.created_at), format_time(row.confirmed_at)
        yield {"class": name, "address": row.address, "asked_at": asked, "confirmed_at": confirmed}
