"""Builds the page of the courses that are tied to a class, with the marks that are sent to them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy.orm import Session

from server.assignments import repository as assignments
from server.assignments.models import Assignment
from server.classes import repository as classes
from server.course import Course
from server.desk.views import class_head
from server.federation import outbox_repository, repository
from server.federation.models import DeliveryState, LineItem, MarkDelivery, ProviderContext
from server.rights.service import ClassAccess

PATH = "/reglages"


@dataclass(frozen=True)
class SentAssignment:
    """An assignment whose marks go to a course: its line item, and its deliveries with names, by name."""

    assignment: Assignment
    item: LineItem
    counts: Counter[str]
    rows: Sequence[tuple[str, MarkDelivery]]


@dataclass(frozen=True)
class TiedCourse:
    context: ProviderContext
    platform: str
    sent: Sequence[SentAssignment]
    others: Sequence[Assignment]


def build_school_page(db: Session, course: Course, access: ClassAccess) -> dict[str, Any]:
    class_id = access.school_class.id
    names = {member.id: member.name for member in classes.load_members(db, class_id)}
    return {
        "head": class_head(course, access, PATH),
        "courses": [
            _tied_course(db, context, provider.name, names)
            for context, provider in repository.load_class_contexts(db, class_id)
        ],
        "states": DeliveryState,
    }


def _tied_course(db: Session, context: ProviderContext, platform: str, names: dict[Any, str]) -> TiedCourse:
    items = outbox_repository.load_line_items(db, context.id)
    deliveries = outbox_repository.load_deliveries(db, [item.id for item, _ in items])
    assert context.class_id is not None
    sent = []
    for item, assignment in items:
        rows = [
            (names.get(account_id, "parti de la classe"), row)
            for (line_item_id, account_id), row in deliveries.items()
            if line_item_id == item.id
        ]
        rows.sort(key=lambda pair: (pair[1].state != DeliveryState.refused, pair[0]))
        sent.append(SentAssignment(assignment, item, Counter(row.state for _, row in rows), rows))
    chosen = {assignment.id for _, assignment in items}
    every = assignments.load_class_assignments(db, context.class_id)
    return TiedCourse(context, platform, sent, [row for row in every if row.id not in chosen])
