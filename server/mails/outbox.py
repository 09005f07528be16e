"""The queue of mails: what is taken, and what came of it. Functions work in the caller's transaction."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.identity.models import Account
from server.mails import repository
from server.mails.errors import LostAnswerError, MailError
from server.mails.models import REASON_LENGTH, MailDelivery, MailState, MailSubscription

FIRST_PAUSE, LONGEST_PAUSE = timedelta(minutes=1), timedelta(hours=4)
MAX_TRIES = 8  # over some ten hours
#: A mail that was handed over so long ago, and of which nothing more was recorded: its process died.
HANDOVER = timedelta(minutes=10)
LOST = "Envoi interrompu : le message est peut-être arrivé, il n’est pas envoyé une seconde fois."


@dataclass(frozen=True)
class OutgoingMail:
    """A mail on its way, with whom it goes to."""

    id: UUID
    key: str
    tries: int
    subscription: MailSubscription
    account: Account


def retry_delay(tries: int) -> timedelta:
    """Return how long to wait after so many tries: 1 minute, 4, 16, then at most 4 hours."""
    return min(FIRST_PAUSE * 4.0 ** min(tries - 1, 6), LONGEST_PAUSE)


def has_due_mail(db: Session, now: datetime) -> bool:
    return repository.has_due_mail(db, now, now - HANDOVER)


def queue_mail(db: Session, subscription_id: UUID, key: str, now: datetime) -> None:
    """Add a mail to send, unless it is there, or its subscription was stopped meanwhile."""
    if repository.lock_subscription(db, subscription_id) is not None:
        repository.add_delivery(db, subscription_id, key, now)


def take_next_due_mail(db: Session, now: datetime) -> OutgoingMail | None:
    """Take the next mail that is due; where this process dies meanwhile, it is due again after the pause."""
    row = repository.lock_next_due_delivery(db, now)
    if row is None:
        return None
    delivery, subscription, account = row
    delivery.tries += 1
    delivery.next_try_at = now + retry_delay(delivery.tries)
    return OutgoingMail(delivery.id, delivery.key, delivery.tries, subscription, account)


def record_handover(db: Session, sending: OutgoingMail, now: datetime) -> bool:
    """Record that the message leaves now. False where the mail was stopped meanwhile: it is not to leave."""
    delivery = repository.lock_delivery(db, sending.id)
    if delivery is None or delivery.state != MailState.waiting or delivery.tries != sending.tries:
        return False
    delivery.state, delivery.next_try_at = MailState.handed, now
    return True


def record_result(db: Session, sending: OutgoingMail, error: MailError | None, now: datetime) -> None:
    """Record what came of a mail, unless it was stopped or taken by another process since."""
    delivery = repository.lock_delivery(db, sending.id)
    if delivery is None or delivery.tries != sending.tries:
        return
    if error is None:
        _end_delivery(delivery, MailState.sent, "", now)
    elif isinstance(error, LostAnswerError):
        _end_delivery(delivery, MailState.unknown, LOST, now)
    elif error.retry and sending.tries < MAX_TRIES:
        delivery.state, delivery.next_try_at = MailState.waiting, now + retry_delay(sending.tries)
        delivery.reason = f"Nouvel essai prévu : {error.reason}."[:REASON_LENGTH]
    else:
        _end_delivery(delivery, MailState.refused, f"Abandonné : {error.reason}.", now)


def drop_mail(db: Session, sending: OutgoingMail, now: datetime) -> None:
    """End a mail that has nothing to tell."""
    delivery = repository.lock_delivery(db, sending.id)
    if delivery is not None:
        _end_delivery(delivery, MailState.dropped, "", now)


def end_mails_lost_after_handover(db: Session, now: datetime) -> None:
    """End the mails whose process died after the handover: they are never sent again."""
    for delivery in repository.load_deliveries_handed_before(db, now - HANDOVER):
        _end_delivery(delivery, MailState.unknown, LOST, now)


def _end_delivery(delivery: MailDelivery, state: MailState, reason: str, now: datetime) -> None:
    delivery.state, delivery.reason, delivery.ended_at = state, reason[:REASON_LENGTH], now
