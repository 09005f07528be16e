"""Create tokens and hash passwords."""

import hashlib
import secrets
from functools import lru_cache

from pwdlib import PasswordHash

from server.text.lines import normalise_line

API_PREFIX = "balise_"
CODE_LETTERS, CODE_LENGTH = "ABCDEFGHJKMNPQRSTUVWXYZ23456789", 8  # without 0, O, 1, I, L


def draw_secret_token(prefix: str = "") -> str:
    """Return a secret of 256 bits, fit for a URL or a header."""
    return prefix + secrets.token_urlsafe(32)


def draw_link_code() -> str:
    """Return a code of 8 readable characters, some 40 random bits: tries are rate limited, and each code ends soon."""
    return "".join(secrets.choice(CODE_LETTERS) for _ in range(CODE_LENGTH))


def normalise_typed_token(text: str) -> str:
    """Return the token of a link: a code as it is typed, in any case and with spaces and dashes, or the text itself."""
    code = "".join(letter for letter in normalise_line(text).upper() if letter not in " -–—")
    return code if len(code) == CODE_LENGTH and set(code) <= set(CODE_LETTERS) else text


def format_link_code(code: str) -> str:
    """Format a code for reading: ABCD-EFGH."""
    return f"{code[: CODE_LENGTH // 2]}-{code[CODE_LENGTH // 2 :]}"


def sha256_hex(text: str) -> str:
    """Return the SHA-256 of a text, as stored of a token: with its 256 random bits, a plain hash is enough."""
    return hashlib.sha256(text.encode("utf-8", errors="replace")).hexdigest()


@lru_cache(maxsize=1)
def _password_hash() -> PasswordHash:
    return PasswordHash.recommended()


def hash_password(password: str) -> str:
    """Hash with Argon2id, in about 0.1 s: see `server.identity.hashing`."""
    return _password_hash().hash(password)


def verify_password(password: str, stored: str | None) -> bool:
    """Verify a password in the same time whether the account exists (`stored` given) or not."""
    return _password_hash().verify(password, stored or _decoy_hash()) and stored is not None


@lru_cache(maxsize=1)
def _decoy_hash() -> str:
    return hash_password(secrets.token_hex(16))
