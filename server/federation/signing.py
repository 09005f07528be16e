"""Our own keys: made when they are first wanted, replaced in time, and published (JWKS) before and after they sign."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from sqlalchemy.orm import Session

from server.database import Database, utc_now
from server.federation import repository
from server.federation.models import SigningKey

if TYPE_CHECKING:
    from joserfc.jwk import RSAKey

KEY_BITS, ALGORITHM = 2048, "RS256"
#: A key signs from when platforms have had time to fetch it, and stays published after the next one has begun to.
LEAD_TIME, LIFETIME, OVERLAP = timedelta(days=1), timedelta(days=90), timedelta(days=14)
TOKEN_SECONDS = 300
CLOCK_SECONDS = 5  # by which the clock of a platform may be behind ours


def _needs_new_key(keys: Sequence[SigningKey], now: datetime) -> bool:
    return not keys or now - keys[0].created_at > LIFETIME


def _new_pem() -> str:
    """Return a new private key. It takes a tenth of a second or more, and is called outside of transactions."""
    from joserfc.jwk import RSAKey

    pem: str = RSAKey.generate_key(KEY_BITS).as_pem(private=True).decode()
    return pem


def _store_key_if_needed(db: Session, pem: str, now: datetime) -> None:
    """Add this key where the newest is old, and delete those that nobody needs. Works in a writing transaction."""
    repository.lock_signing_keys(db)
    keys = repository.load_signing_keys(db)
    if not _needs_new_key(keys, now):
        return
    db.add(SigningKey(private_pem=pem, created_at=now))
    for key in keys[1:]:
        db.delete(key)
    for key in keys[:1]:
        if now - key.created_at > LIFETIME + LEAD_TIME + OVERLAP:
            db.delete(key)


def choose_signing_key(keys: Sequence[SigningKey], now: datetime) -> SigningKey:
    """Return the newest key that has been published for long enough, else the oldest; `keys` are newest first."""
    return next((key for key in keys if now - key.created_at >= LEAD_TIME), keys[-1])


def load_keys(database: Database, now: datetime) -> Sequence[SigningKey]:
    """Load our keys, newest first; the first one is made where there is none."""
    with database.read() as db:
        keys = repository.load_signing_keys(db)
    if _needs_new_key(keys, now):
        pem = _new_pem()
        with database.write() as db:
            _store_key_if_needed(db, pem, now)
        with database.read() as db:
            keys = repository.load_signing_keys(db)
    return keys


def published_keys(database: Database) -> Mapping[str, Any]:
    """Return the document (JWKS) of our public keys."""
    return {"keys": [_public_jwk(key) for key in load_keys(database, utc_now())]}


@lru_cache(maxsize=4)
def _import_private_key(private_pem: str) -> RSAKey:
    """Return the key of a text, whose numbers are checked: 28 ms of the processor, at an address open to anybody."""
    from joserfc.jwk import RSAKey

    return RSAKey.import_key(private_pem)


def _public_jwk(key: SigningKey) -> Mapping[str, Any]:
    document = dict(_import_private_key(key.private_pem).as_dict(private=False))
    return {**document, "kid": str(key.id), "alg": ALGORITHM, "use": "sig"}


def sign_claims(database: Database, claims: Mapping[str, Any], seconds: int = TOKEN_SECONDS) -> str:
    """Return a signed token with these claims, which lasts so many seconds."""
    from joserfc import jwt

    moment = utc_now()
    key = choose_signing_key(load_keys(database, moment), moment)
    now = int(time.time())
    header = {"alg": ALGORITHM, "kid": str(key.id), "typ": "JWT"}
    whole = {"iat": now - CLOCK_SECONDS, "exp": now + seconds, **claims}
    token: str = jwt.encode(header, whole, _import_private_key(key.private_pem))
    return token
