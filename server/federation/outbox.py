"""The marks that go to platforms: each student's, compared with the gradebook, and what came of sending it.

A mark is sent when it is final and published, and nothing is ever sent for nothing. Functions work inside the caller's
transaction.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.classes.models import SchoolClass
from server.course import Course
from server.federation import outbox_repository, repository
from server.federation.errors import OutgoingError
from server.federation.models import (
    ADDRESS_LENGTH,
    REASON_LENGTH,
    DeliveryState,
    IdentityProvider,
    LineItem,
    MarkDelivery,
    ProviderContext,
)
from server.marks.loading import load_gradebook
from server.marks.schemas import AssignmentMark, is_test_withheld
from server.marks.states import MarkState

#: Timestamps of a student's scores differ by this at least: platforms compare whole seconds.
TICK = timedelta(seconds=1)
FIRST_PAUSE, LONGEST_PAUSE = timedelta(seconds=5), timedelta(hours=1)
#: Tries in all; after answers that ours is older; after answers that the line item, which is looked for anew, is gone.
MAX_TRIES, MAX_CONFLICTS, MAX_LOST = 200, 12, 3
DIGITS = 4
ASSIGNMENT_PAGE = re.compile(r"/classes/([^/]+)/devoirs/([0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12})")
GONE = "La note n’est plus dans le carnet : la plateforme garde celle qu’elle a reçue."
NEWER = "La plateforme dit avoir une note plus récente."
REASONS: Mapping[int, str] = {
    400: "La plateforme ne prend pas de note pour cette personne (réponse 400) : elle a peut-être quitté le cours.",
    401: "La plateforme ne nous donne pas accès à son carnet (réponse 401).",
    403: "La plateforme ne nous laisse pas noter (réponse 403) : vérifiez les services de l’outil dans ses réglages.",
    404: "La colonne ou la personne n’existe plus dans la plateforme (réponse 404).",
}


def final_points(mark: AssignmentMark, assignment: Assignment, now: datetime) -> float | None:
    """Return the points of a mark that is final and published: with work, or by a teacher's decision; else None."""
    if is_test_withheld(assignment, now) or mark.has_no_end or mark.state is not MarkState.done:
        return None
    if mark.decision is None and all(exercise.points is None for exercise in mark.exercises):
        return None
    return None if mark.points is None else round(mark.points, DIGITS)


def queue_changed_marks(
    db: Session,
    course: Course,
    context: ProviderContext,
    provider: IdentityProvider,
    school_class: SchoolClass,
    now: datetime,
) -> None:
    """Have each mark of a course's line items that differs from the one that was sent, sent."""
    items = {assignment.id: item for item, assignment in outbox_repository.load_line_items(db, context.id)}
    gradebook = load_gradebook(db, course, school_class, now)
    known = repository.load_identified_members(db, provider.issuer, {row.member.id for row in gradebook.rows})
    deliveries = dict(outbox_repository.load_deliveries(db, [item.id for item in items.values()]))
    for row in gradebook.rows:
        if row.member.id not in known:
            continue
        for mark, assignment in zip(row.marks, gradebook.assignments, strict=True):
            item = items.get(assignment.id)
            if item is not None:
                points = final_points(mark, assignment, now)
                _queue_if_changed(db, deliveries.get((item.id, row.member.id)), item, row.member.id, points, now)


def _queue_if_changed(
    db: Session, delivery: MarkDelivery | None, item: LineItem, account_id: UUID, points: float | None, now: datetime
) -> None:
    if delivery is None:
        if points is not None:
            db.add(MarkDelivery(line_item_id=item.id, account_id=account_id, points=points, next_try_at=now))
    elif points is None:
        if delivery.sent_points is None and delivery.told_at is None:
            db.delete(delivery)
        elif delivery.state == DeliveryState.waiting or not delivery.reason:
            delivery.state, delivery.reason = DeliveryState.refused, GONE
    elif delivery.points != points or delivery.reason == GONE:
        delivery.points, delivery.state, delivery.reason = points, DeliveryState.waiting, ""
        delivery.tries, delivery.next_try_at = 0, now


def adopt_launch_line_item(db: Session, context: ProviderContext, page: str, line_item_url: str, now: datetime) -> None:
    """Send an assignment's marks to the column of the link that opens it, unless they have a column already.

    A platform may let nobody make columns (Open edX), and a second one beside that of the link would stay empty.
    """
    found = ASSIGNMENT_PAGE.fullmatch(page.partition("?")[0])
    if found is not None and line_item_url and found[1] == str(context.class_id):
        outbox_repository.set_missing_line_item_url(db, context.id, UUID(found[2]), line_item_url[:ADDRESS_LENGTH], now)


@dataclass(frozen=True)
class MarkSending:
    """A mark on its way: `told_at` is its timestamp, committed before it is sent."""

    line_item_id: UUID
    account_id: UUID
    subject: str
    points: float
    told_at: datetime
    tries: int


def begin_sending(
    db: Session, item_ids: Sequence[UUID], issuer: str, now: datetime, limit: int
) -> Sequence[MarkSending]:
    """Take marks that are due, each with a timestamp that is later by a second than any before."""
    batch = []
    for delivery, subject in outbox_repository.load_due_deliveries(db, item_ids, issuer, now, limit):
        told_at = now.replace(microsecond=0)
        if delivery.told_at is not None:
            told_at = max(told_at, delivery.told_at.replace(microsecond=0) + TICK)
        delivery.told_at, delivery.tries = told_at, delivery.tries + 1
        delivery.next_try_at = now + retry_delay(delivery.tries)  # of a process that dies meanwhile
        batch.append(
            MarkSending(delivery.line_item_id, delivery.account_id, subject, delivery.points, told_at, delivery.tries)
        )
    return batch


def retry_delay(tries: int) -> timedelta:
    """Return how long to wait after so many tries."""
    return min(FIRST_PAUSE * 2.0 ** min(tries - 1, 12), LONGEST_PAUSE)


def record_result(db: Session, sending: MarkSending, error: OutgoingError | None, now: datetime) -> None:
    """Record what came of sending a mark, unless another one was sent since."""
    delivery = outbox_repository.find_delivery(db, sending.line_item_id, sending.account_id)
    if delivery is None or delivery.told_at != sending.told_at:
        return
    if error is None:
        delivery.sent_points, delivery.sent_at = sending.points, now
        if delivery.points == sending.points and delivery.state == DeliveryState.waiting:
            delivery.state, delivery.reason, delivery.tries = DeliveryState.sent, "", 0
    elif delivery.points != sending.points or delivery.state != DeliveryState.waiting:
        return
    elif error.status == 409:
        _retry_with_later_timestamp(delivery, now)
    elif (error.retry and sending.tries < MAX_TRIES) or (error.status == 404 and sending.tries < MAX_LOST):
        delivery.reason = f"Nouvel essai prévu : {error.reason}."[:REASON_LENGTH]
        delivery.next_try_at = now + max(retry_delay(sending.tries), timedelta(seconds=error.retry_after))
    else:
        reason = REASONS.get(error.status, f"La plateforme refuse : {error.reason}.")
        delivery.state, delivery.reason = DeliveryState.refused, reason[:REASON_LENGTH]


def _retry_with_later_timestamp(delivery: MarkDelivery, now: datetime) -> None:
    """Go on with a later timestamp: ours was not later than one that the platform has."""
    assert delivery.told_at is not None
    if delivery.tries >= MAX_CONFLICTS:
        delivery.state, delivery.reason = DeliveryState.refused, NEWER
        return
    delivery.told_at += TICK * 2 ** min(delivery.tries, 12)
    delivery.reason, delivery.next_try_at = f"Nouvel essai prévu : {NEWER}", now
