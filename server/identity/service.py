"""Guests, sign-up, log-in, API tokens, and the one-time link of the first teacher.

Functions that take `db` work inside the caller's transaction. Password hashing takes 0.1 s: the two entries that need
it, `Accounts.sign_up` and `Accounts.log_in`, hash outside of any transaction.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import Conflict, NotFound
from server.base.settings import Settings
from server.database import Database, utc_now
from server.identity import repository, secrets
from server.identity.models import Account, ApiToken, BrowserSession, Invitation, Role
from server.identity.schemas import NewAccount, RefusedForm, normalised_login, token_label
from server.limits import service as limits

ALLOWANCES_KEPT = timedelta(days=7)
GUEST_NAME = "Invité"
TAKEN = "Cet identifiant est déjà pris."
WRONG_LOGIN = "Identifiant ou mot de passe incorrect."
TOO_MANY_LOGINS = "Trop d’essais de connexion : réessayez dans {seconds} s."
TOO_MANY_GUESTS = "Trop de nouveaux visiteurs depuis cette adresse : réessayez dans {seconds} s."
USED_LINK = "Ce lien a déjà servi, ou n’existe pas."


@dataclass(frozen=True)
class Opened:
    """A browser session that has just been opened; `token` goes in the cookie and nowhere else."""

    account: Account
    token: str


#: Gives what a guest (first id) has done to the account (second id) that the same person has just opened.
Adopt = Callable[[Session, UUID, UUID], None]


@dataclass(frozen=True)
class Accounts:
    """Comes and goes of people. `adopt` says what follows a guest into an account."""

    database: Database
    settings: Settings
    adopt: Adopt

    def welcome(self, address: str) -> Opened:
        """A new guest: a real account, bound to nothing but the session that is opened for it. Raises TooMany."""
        with self.database.write() as db:
            limits.take(db, f"guest:{address}", self.settings.guest_bucket, TOO_MANY_GUESTS)
            account = Account(role=Role.guest, name=GUEST_NAME)
            db.add(account)
            db.flush()
            return self._open_session(db, account)

    def sign_up(self, wanted: NewAccount, *, visitor: Account | None, invitation: str | None = None) -> Opened:
        """Makes a named account: a guest `visitor` becomes it, with its work. `invitation` gives its role."""
        hashed = secrets.hash_password(wanted.password)
        with self.database.write() as db:
            role = Role.student if invitation is None else _use_invitation(db, invitation)
            if repository.by_login(db, wanted.login) is not None:
                raise RefusedForm({"login": TAKEN})
            account = _account_to_name(db, visitor)
            account.role, account.name, account.login, account.password_hash = role, wanted.name, wanted.login, hashed
            db.flush()
            repository.delete_sessions_of(db, account.id)
            return self._open_session(db, account)

    def log_in(self, login: str, password: str, *, visitor: Account | None, address: str) -> Opened:
        """Opens a session; a guest `visitor`'s work joins the account. Raises RefusedForm or TooMany."""
        login = normalised_login(login)
        with self.database.write() as db:
            key = f"login:{secrets.digest(f'{login} {address}')}"
            limits.take(db, key, self.settings.login_bucket, TOO_MANY_LOGINS)
            limits.take(db, f"login-from:{address}", self.settings.guest_bucket, TOO_MANY_LOGINS)
        with self.database.read() as db:
            account = repository.by_login(db, login)
        if not secrets.verify_password(password, account.password_hash if account else None) or account is None:
            raise RefusedForm({"password": WRONG_LOGIN})
        with self.database.write() as db:
            if visitor is not None and visitor.is_guest:
                self.adopt(db, visitor.id, account.id)
                repository.delete_account(db, visitor.id)
            return self._open_session(db, account)

    def _open_session(self, db: Session, account: Account) -> Opened:
        token = secrets.new_token()
        expires = utc_now() + timedelta(days=self.settings.session_days)
        db.add(BrowserSession(token_digest=secrets.digest(token), account_id=account.id, expires_at=expires))
        return Opened(account, token)


def _account_to_name(db: Session, visitor: Account | None) -> Account:
    guest = repository.by_id(db, visitor.id) if visitor is not None and visitor.is_guest else None
    account = guest or Account(name=GUEST_NAME)
    db.add(account)
    return account


def close_session(db: Session, token: str) -> None:
    repository.delete_session(db, secrets.digest(token))


def forget_stale(db: Session) -> None:
    """Removes sessions that have ended, and token buckets that have been full again for long."""
    now = utc_now()
    repository.delete_ended_sessions(db, now)
    limits.forget(db, before=now - ALLOWANCES_KEPT)


def account_of_session(db: Session, token: str) -> Account | None:
    return repository.by_session(db, secrets.digest(token), utc_now())


def account_of_api_token(db: Session, token: str) -> Account | None:
    return repository.by_api_token(db, secrets.digest(token))


def invite_first_teacher(db: Session) -> str | None:
    """A fresh one-time token (older unused ones stop working), or None once a teacher exists."""
    if repository.teacher_exists(db):
        return None
    repository.delete_unused_invitations(db, Role.teacher)
    token = secrets.new_token()
    db.add(Invitation(token_digest=secrets.digest(token), role=Role.teacher))
    return token


def check_invitation(db: Session, token: str) -> Invitation:
    invitation = repository.open_invitation(db, secrets.digest(token))
    if invitation is None:
        raise NotFound(USED_LINK)
    return invitation


def _use_invitation(db: Session, token: str) -> Role:
    role = repository.use_invitation(db, secrets.digest(token), utc_now())
    if role is None:
        raise Conflict(USED_LINK)
    return role


def new_api_token(db: Session, account: Account, label: str) -> tuple[ApiToken, str]:
    """The token's row, and its secret: shown once, never stored."""
    secret = secrets.new_token(secrets.API_PREFIX)
    token = ApiToken(account_id=account.id, label=token_label(label), token_digest=secrets.digest(secret))
    db.add(token)
    db.flush()
    return token, secret


def api_tokens(db: Session, account: Account) -> Sequence[ApiToken]:
    return repository.tokens_of(db, account.id)


def revoke_api_token(db: Session, account: Account, token_id: UUID) -> None:
    if not repository.delete_token(db, account.id, token_id):
        raise NotFound("Ce jeton n’existe pas, ou a déjà été révoqué.")
