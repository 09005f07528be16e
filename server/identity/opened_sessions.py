"""Sessions as they are opened, proofs of a password, and what the rooms above do with the work of an account."""

from collections.abc import Callable
from dataclasses import dataclass
from uuid import UUID

from sqlalchemy.orm import Session

from server.database import utc_now
from server.identity import repository, secrets
from server.identity.models import Account


@dataclass(frozen=True)
class OpenedSession:
    """A browser session that has just been opened; `token` and `device` go in cookies and nowhere else.

    `device` is the token by which the browser is known from now on; empty for a guest, who has no password.
    `is_framed`: the session is for the frame of another site's page.
    """

    account: Account
    token: str
    device: str = ""
    is_framed: bool = False


@dataclass(frozen=True)
class SessionOrigin:
    """The identity that opened a session, and the fields of `BrowserSession` that it sets."""

    identity_id: UUID | None = None
    external_digest: str | None = None
    frames: str = ""


@dataclass(frozen=True)
class PasswordProof:
    """The stored hash against which an account's password was verified, to compare once the account is locked.

    None for an account without a password, whose session an identity has just opened.
    """

    account_id: UUID
    password_hash: str | None


#: Moves the work of a guest (first id) to the account (second id) of the same person.
AdoptGuestData = Callable[[Session, UUID, UUID], None]
#: Records in the log that an account was made by an invitation.
RecordInvited = Callable[[Session, Account], None]
#: Raises Conflict where the work of an account (first id) cannot move to another one (second id).
JoinCheck = Callable[[Session, UUID, UUID], None]


def frames_of_session(db: Session, token: str) -> str:
    """Return the origins that may show a session in a frame, separated by spaces; empty for none."""
    session = repository.find_session(db, secrets.sha256_hex(token), utc_now())
    return "" if session is None else session.frames


def record_nothing(_db: Session, _account: Account) -> None:
    pass


def accept_every_join(_db: Session, _newcomer_id: UUID, _account_id: UUID) -> None:
    return None
