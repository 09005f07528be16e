"""Browsers in which an account has logged in before: they have log-in attempts of their own (OWASP, "device cookies").

A school shares one address, so that wrong passwords typed by neighbours use up the attempts of an account from there.
A known browser neither uses these nor is refused with them. Functions work inside the caller's transaction.
"""

from datetime import datetime, timedelta
from uuid import UUID, uuid4

from sqlalchemy.orm import Session

from server.identity import repository, secrets
from server.identity.models import Account

#: A browser is forgotten after so many days without a log-in.
DEVICE_DAYS = 365
MAX_DEVICES = 20  # of one account: the least recent are forgotten


def is_known_device(db: Session, device: str, account: Account | None) -> bool:
    """Whether an account has logged in from the browser that has this token; nobody is looked for as somebody is."""
    account_id = uuid4() if account is None else account.id
    return bool(device) and repository.is_device_known(db, secrets.sha256_hex(device), account_id)


def remember_device(db: Session, account_id: UUID, device: str, now: datetime) -> str:
    """Remember that an account has logged in from a browser; return the browser's token.

    A token that this server has not made is replaced: nobody chooses one for somebody else.
    """
    token = (
        device
        if device and repository.does_device_exist(db, secrets.sha256_hex(device))
        else secrets.draw_secret_token()
    )
    repository.upsert_device(db, secrets.sha256_hex(token), account_id, now)
    repository.delete_devices_beyond(db, account_id, MAX_DEVICES)
    return token


def forget_stale_devices(db: Session, now: datetime) -> None:
    repository.delete_stale_devices(db, now - timedelta(days=DEVICE_DAYS))
