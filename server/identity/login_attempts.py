"""Tries to log in, counted by account and address before a password is checked."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from sqlalchemy.orm import Session

from server.base.errors import RateLimited
from server.base.settings import Settings
from server.base.turns import out_of_turn
from server.identity import devices, repository, secrets
from server.identity.hashing import KNOWN, NOBODY, UNKNOWN
from server.identity.logins import normalise_login
from server.identity.models import Account
from server.limits import service as limits

#: Seconds after which a log-in is refused from an address that floods: longer than a password takes.
FLOODED_SECONDS = 2.0
TOO_MANY_LOGINS = "Trop d’essais de connexion : réessayez dans {seconds} s."


@dataclass(frozen=True)
class CountedLoginAttempt:
    """A try to log in that has been counted: the login as it is compared, its account, its rank among those whose
    passwords wait to be checked, and the keys of the token buckets to give back to.

    `seconds_refused`: where too many logins of nobody were tried from there, seconds until one more may; else 0.
    """

    login: str
    account: Account | None
    rank: int
    buckets: Sequence[str] = ()
    seconds_refused: int = 0
    began: float = field(default_factory=time.monotonic)

    async def delayed_refusal(self) -> RateLimited:
        """Return the error, as long after the beginning whether the account exists or not."""
        async with out_of_turn():
            await asyncio.sleep(self.began + FLOODED_SECONDS - time.monotonic())
        return limits.rate_limited_error(TOO_MANY_LOGINS, self.seconds_refused)


def begin_login(db: Session, settings: Settings, login: str, address: str, device: str) -> CountedLoginAttempt:
    """Count a try to log in. Raises RateLimited.

    A browser in which the account has logged in before has a bucket of its own, whatever is tried elsewhere; all other
    tries count by account and address, and by address. There, the tries of logins that are nobody's have a bucket of
    their own: who floods an address with them keeps nobody from a first log-in there. Once it is empty, every wrong
    password is refused in the same words after the same time, so that nobody learns who exists.
    """
    account = repository.find_account_by_typed_login(db, login)
    folded = normalise_login(login)
    if devices.is_known_device(db, device, account):
        own = f"login-in:{secrets.sha256_hex(f'{folded} {device}')}"
        limits.take_token(db, own, settings.login_bucket, TOO_MANY_LOGINS)
        return CountedLoginAttempt(folded, account, KNOWN, [own])
    own = f"login:{secrets.sha256_hex(f'{folded} {address}')}"
    everyone, nobody = f"login-from:{address}", f"login-nobody:{address}"
    limits.take_token(db, own, settings.login_bucket, TOO_MANY_LOGINS)
    refused = limits.seconds_until_token(db, nobody, settings.guest_bucket)
    if account is not None:
        limits.take_token(db, everyone, settings.guest_bucket, TOO_MANY_LOGINS)
        return CountedLoginAttempt(folded, account, UNKNOWN, [own, everyone], refused)
    if not refused:
        limits.take_token(db, nobody, settings.guest_bucket, TOO_MANY_LOGINS)
    return CountedLoginAttempt(folded, None, NOBODY, seconds_refused=refused)
