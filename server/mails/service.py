"""Ask for the mails of a class, confirm their address, and stop them. Functions work in the caller's transaction."""

from __future__ import annotations

import hmac
import re
import secrets
from dataclasses import dataclass
from datetime import datetime, timedelta
from hashlib import sha256
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import InvalidFields, NotFound
from server.base.settings import BucketSettings
from server.base.validation import parse_uuid
from server.classes.models import SchoolClass
from server.identity.models import Account
from server.limits import service as limits
from server.limits.service import TokenDraw
from server.mails import repository
from server.mails.models import ADDRESS_LENGTH, URL_LENGTH, MailDelivery, MailSubscription

CONFIRM, STOP = "confirmer", "arreter"
#: The key of the mail that asks to confirm an address.
CONFIRMATION = "confirmation"
#: Of an account and of an address: confirmations that are sent, so that no stranger's mailbox is filled.
CONFIRMATIONS = BucketSettings(burst=4, refill_seconds=3600)
UNCONFIRMED_DAYS, DELIVERY_DAYS = 7, 30
#: RFC 5321 without quoted local parts and address literals, and without letters that need SMTPUTF8.
ADDRESS = re.compile(
    r"[A-Za-z0-9!#$%&'*+/=?^_`{|}~-]+(\.[A-Za-z0-9!#$%&'*+/=?^_`{|}~-]+)*"
    r"@([A-Za-z0-9]([A-Za-z0-9-]{0,61}[A-Za-z0-9])?\.)+[A-Za-z][A-Za-z0-9-]{0,61}[A-Za-z0-9]"
)
NO_ADDRESS = "Ce n’est pas une adresse électronique : écrivez-la comme prenom.nom@lycee.example, sans accent."
TOO_MANY = "Trop de demandes de confirmation : réessayez dans {seconds} secondes."
UNKNOWN_LINK = (
    "Ce lien ne sert plus : l’envoi a été arrêté, ou une autre adresse a été donnée depuis. La page "
    "« Après la séance » de la classe le dit."
)


@dataclass(frozen=True)
class MailForm:
    """An account's subscription to a class, if it has one, and the form that asks for it.

    `address` is the one that receives, or the one to propose; `latest` is the latest mail.
    """

    address: str
    is_asked: bool = False
    is_confirmed: bool = False
    latest: MailDelivery | None = None
    problem: str = ""


def parse_mail_address(text: str) -> str:
    """Return an address to which mails may go. Raises InvalidFields."""
    address = text.strip()
    local = address.partition("@")[0]
    if len(address) > ADDRESS_LENGTH or len(local) > 64 or not ADDRESS.fullmatch(address):
        raise InvalidFields({"address": NO_ADDRESS})
    return address


def load_mail_form(db: Session, class_id: UUID, account: Account) -> MailForm:
    """Return the form of an account for a class; a login that is an address is proposed."""
    row = repository.find_subscription(db, class_id, account.id)
    if row is None:
        return MailForm(account.login if account.login and ADDRESS.fullmatch(account.login) else "")
    latest = repository.find_latest_delivery(db, row.id)
    return MailForm(row.address, is_asked=True, is_confirmed=row.confirmed_at is not None, latest=latest)


def request_subscription(
    db: Session, school_class: SchoolClass, account: Account, text: str, service_url: str, now: datetime
) -> None:
    """Ask to confirm an address, which replaces an earlier one. Raises InvalidFields or RateLimited."""
    address = parse_mail_address(text)
    if len(service_url) > URL_LENGTH:
        raise InvalidFields({"address": NO_ADDRESS})
    limits.take_tokens(
        db,
        TokenDraw(f"mail:{account.id}", CONFIRMATIONS, TOO_MANY),
        TokenDraw(f"mail-to:{sha256(address.lower().encode()).hexdigest()}", CONFIRMATIONS, TOO_MANY),
    )
    delete_subscription(db, school_class.id, account.id)
    row = MailSubscription(
        class_id=school_class.id, account_id=account.id, address=address, secret=secrets.token_hex(32),
        service_url=service_url, created_at=now,
    )  # fmt: skip
    db.add(row)
    db.flush()
    repository.add_delivery(db, row.id, CONFIRMATION, now)


def delete_subscription(db: Session, class_id: UUID, account_id: UUID) -> None:
    row = repository.find_subscription(db, class_id, account_id)
    if row is not None:
        repository.delete_subscription(db, row.id)
        db.expunge(row)


def sign_link_action(subscription: MailSubscription, action: str) -> str:
    """Return the signature of a link that does `action` to this subscription and its address."""
    text = f"{action} {subscription.id} {subscription.address}"
    return hmac.new(subscription.secret.encode(), text.encode(), sha256).hexdigest()


def signed_link_href(subscription: MailSubscription, action: str) -> str:
    return f"/courriel/{subscription.id}/{action}/{sign_link_action(subscription, action)}"


def find_signed_subscription(
    db: Session, name: str, action: str, signature: str
) -> tuple[MailSubscription, SchoolClass]:
    """Return the subscription of a signed link, with its class. Raises NotFound."""
    row = repository.find_subscription_with_class(db, parse_uuid(name, UNKNOWN_LINK))
    if row is None or action not in {CONFIRM, STOP}:
        raise NotFound(UNKNOWN_LINK)
    if not hmac.compare_digest(sign_link_action(row[0], action).encode(), signature.encode("utf-8", "replace")):
        raise NotFound(UNKNOWN_LINK)
    return row


@dataclass(frozen=True)
class SignedLink:
    """A link of a mail, as its page shows it; `done`: its button was pressed."""

    class_name: str
    address: str
    stops: bool
    is_confirmed: bool
    done: bool = False


def read_signed_link(db: Session, name: str, action: str, signature: str) -> SignedLink:
    """Return what a link does. Raises NotFound."""
    row, school_class = find_signed_subscription(db, name, action, signature)
    return SignedLink(school_class.name, row.address, action == STOP, row.confirmed_at is not None)


def confirm_or_delete_subscription(db: Session, name: str, action: str, signature: str, now: datetime) -> SignedLink:
    """Confirm the address of a subscription, or stop it. Raises NotFound."""
    row, school_class = find_signed_subscription(db, name, action, signature)
    followed = SignedLink(school_class.name, row.address, action == STOP, is_confirmed=True, done=True)
    if action == STOP:
        repository.delete_subscription(db, row.id)
    elif row.confirmed_at is None:
        row.confirmed_at = now
    return followed


def delete_old_mails(db: Session, now: datetime) -> None:
    """Forget mails that ended long ago, and requests that nobody has confirmed."""
    repository.delete_old_mails(db, now - timedelta(days=DELIVERY_DAYS), now - timedelta(days=UNCONFIRMED_DAYS))
