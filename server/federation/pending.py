"""Sign-ins that a browser has begun: a state that is used once, by the same browser, with the nonce of its answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import timedelta
from hmac import compare_digest
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from server.database import Database, utc_now
from server.federation import repository
from server.federation.errors import FederationRefused
from server.federation.models import PendingSignIn
from server.identity.secrets import draw_secret_token, sha256_hex

LIFETIME = timedelta(minutes=10)
NONCE = "nonce"
COOKIE_PREFIX, NAME_DIGITS = "balise_etat_", 16
USED = "Cette connexion a déjà servi, ou a trop attendu : recommencez depuis votre établissement."
OTHER_BROWSER = "Cette connexion a été commencée dans un autre navigateur : recommencez depuis votre établissement."


@dataclass(frozen=True)
class BegunSignIn:
    """A sign-in that begins: its state goes to the provider, `browser` in a cookie of the browser."""

    state: str
    browser: str


def cookie_name(state: str) -> str:
    """Return the name of the cookie of a state: several frames of one page may begin at once."""
    return COOKIE_PREFIX + sha256_hex(state)[:NAME_DIGITS]


def begin_sign_in(
    db: Session,
    provider_id: UUID,
    target: str,
    details: Mapping[str, Any],
    *,
    nonce: str = "",
    lifetime: timedelta = LIFETIME,
) -> BegunSignIn:
    """Record a sign-in that begins. Without a nonce, it gets one once the browser has shown that it keeps cookies."""
    begun = BegunSignIn(draw_secret_token(), draw_secret_token())
    db.add(
        PendingSignIn(
            state_digest=sha256_hex(begun.state),
            provider_id=provider_id,
            nonce_digest=sha256_hex(nonce) if nonce else "",
            browser_digest=sha256_hex(begun.browser),
            target=target,
            details=dict(details),
            expires_at=utc_now() + lifetime,
        )
    )
    db.flush()
    return begun


def find_pending_sign_in(db: Session, state: str) -> PendingSignIn:
    """Return a sign-in that has begun and is not used. Raises FederationRefused."""
    pending = repository.find_pending_sign_in(db, sha256_hex(state), utc_now())
    if pending is None:
        raise FederationRefused("state", USED)
    return pending


def require_browser(pending: PendingSignIn, browser: str) -> None:
    """Raise FederationRefused for another browser than the one that has begun."""
    if not browser or not compare_digest(pending.browser_digest, sha256_hex(browser)):
        raise FederationRefused("browser", OTHER_BROWSER)


def replace_nonce(db: Session, pending: PendingSignIn, details: Mapping[str, Any]) -> str:
    """Return a new nonce for a sign-in, which replaces an earlier one. Raises FederationRefused."""
    nonce = draw_secret_token()
    row = repository.set_nonce(db, pending.state_digest, pending.browser_digest, sha256_hex(nonce), details)
    if not row:
        raise FederationRefused("state", USED)
    return nonce


def consume_sign_in(db: Session, pending: PendingSignIn, nonce: object) -> tuple[str, Mapping[str, Any]]:
    """Use a sign-in up, and return its target and details: in one statement, so that it serves once. Raises
    FederationRefused."""
    if not isinstance(nonce, str) or not nonce:
        raise FederationRefused("nonce", USED)
    row = repository.consume_pending_sign_in(
        db, pending.provider_id, pending.state_digest, sha256_hex(nonce), pending.browser_digest, utc_now()
    )
    if row is None:
        raise FederationRefused("replayed", USED)
    return row


def begin_own_sign_in(
    db: Session, provider_id: UUID, target: str, details: Mapping[str, Any], *, lifetime: timedelta = LIFETIME
) -> tuple[BegunSignIn, str]:
    """Record a sign-in that begins on our own page, and return it with its nonce."""
    nonce = draw_secret_token()
    begun = begin_sign_in(db, provider_id, target, {**details, NONCE: nonce}, nonce=nonce, lifetime=lifetime)
    return begun, nonce


def consume_own_sign_in(db: Session, provider_id: UUID, state: str, browser: str) -> tuple[str, Mapping[str, Any]]:
    """Use up a sign-in that this browser has begun on our page, and return its target and details. Raises
    FederationRefused."""
    pending = find_pending_sign_in(db, state)
    if pending.provider_id != provider_id:
        raise FederationRefused("state", USED)
    require_browser(pending, browser)
    return consume_sign_in(db, pending, pending.details.get(NONCE))


def delete_expired(database: Database) -> None:
    with database.write() as db:
        repository.delete_expired(db, utc_now())
