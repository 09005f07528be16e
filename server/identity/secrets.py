"""Tokens and passwords: what is given to people, and what is stored."""

import hashlib
import secrets
from functools import lru_cache

from pwdlib import PasswordHash

API_PREFIX = "balise_"


def new_token(prefix: str = "") -> str:
    """A secret of 256 bits, fit for a URL or a header."""
    return prefix + secrets.token_urlsafe(32)


def digest(token: str) -> str:
    """What is stored of a token: as it has 256 random bits, a plain hash is enough."""
    return hashlib.sha256(token.encode("utf-8", errors="replace")).hexdigest()


@lru_cache(maxsize=1)
def _hasher() -> PasswordHash:
    return PasswordHash.recommended()


def hash_password(password: str) -> str:
    """Argon2id; about 0.1 s on purpose: see `server.identity.hashing`."""
    return _hasher().hash(password)


def verify_password(password: str, stored: str | None) -> bool:
    """Takes the same time whether the account exists (`stored` given) or not."""
    return _hasher().verify(password, stored or _decoy()) and stored is not None


@lru_cache(maxsize=1)
def _decoy() -> str:
    return hash_password(secrets.token_hex(16))
