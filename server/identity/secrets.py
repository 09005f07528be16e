"""Create tokens and hash passwords."""

import hashlib
import secrets
from functools import lru_cache

from pwdlib import PasswordHash

API_PREFIX = "balise_"


def new_token(prefix: str = "") -> str:
    """Return a secret of 256 bits, fit for a URL or a header."""
    return prefix + secrets.token_urlsafe(32)


def digest(token: str) -> str:
    """Return the stored digest of a token; with 256 random bits, a plain hash is enough."""
    return hashlib.sha256(token.encode("utf-8", errors="replace")).hexdigest()


@lru_cache(maxsize=1)
def _hasher() -> PasswordHash:
    return PasswordHash.recommended()


def hash_password(password: str) -> str:
    """Hash with Argon2id, in about 0.1 s: see `server.identity.hashing`."""
    return _hasher().hash(password)


def verify_password(password: str, stored: str | None) -> bool:
    """Verify a password in the same time whether the account exists (`stored` given) or not."""
    return _hasher().verify(password, stored or _decoy()) and stored is not None


@lru_cache(maxsize=1)
def _decoy() -> str:
    return hash_password(secrets.token_hex(16))
