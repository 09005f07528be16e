"""Guests, sign-up, log-in, passwords.

Functions that take `db` work inside the caller's transaction. Whatever needs a password's hash is asynchronous, and
waits for it outside of any transaction (`server.identity.hashing`).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import timedelta
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.counters import REFUSED_LOGINS
from server.base.errors import Conflict, NotFound, RateLimited
from server.base.settings import Settings
from server.database import Database, utc_now
from server.identity import links, repository, secrets
from server.identity.hashing import PasswordHasher
from server.identity.models import Account, BrowserSession, Role
from server.identity.schemas import (
    NewAccount,
    RefusedForm,
    is_valid_login,
    new_account_without_password,
    normalise_login,
    validate_new_password,
)
from server.limits import service as limits

BUCKET_RETENTION = timedelta(days=7)
GUEST_NAME = "Invité"
#: A form must say that a login is not free, and thereby that it exists: the bucket of sign-ups makes asking slow.
TAKEN = "Cet identifiant n’est pas disponible : choisissez-en un autre, ou connectez-vous si c’est le vôtre."
WRONG_PASSWORD = "Ce n’est pas votre mot de passe actuel."
NO_PASSWORD = "Un invité n’a pas de mot de passe."
TOO_MANY_ACCOUNTS = "Trop de comptes créés depuis cette adresse : réessayez dans {seconds} s."
DISABLED = "Ce compte est suspendu : adressez-vous à qui administre ce serveur."
WRONG_LOGIN = "Identifiant ou mot de passe incorrect."
TOO_MANY_LOGINS = "Trop d’essais de connexion : réessayez dans {seconds} s."
LAST_ADMINISTRATOR = "Ce serveur garde au moins un administrateur : nommez-en un autre d’abord."
TOO_MANY_GUESTS = "Trop de nouveaux visiteurs depuis cette adresse : réessayez dans {seconds} s."


@dataclass(frozen=True)
class OpenedSession:
    """A browser session that has just been opened; `token` goes in the cookie and nowhere else."""

    account: Account
    token: str


#: Gives what a guest (first id) has done to the account (second id) that the same person has just opened.
Adopt = Callable[[Session, UUID, UUID], None]


@dataclass(frozen=True)
class AccountService:
    """Comes and goes of people. `adopt` says what follows a guest into an account."""

    database: Database
    settings: Settings
    adopt: Adopt
    hashing: PasswordHasher = field(default_factory=PasswordHasher)

    def create_guest(self, address: str) -> OpenedSession:
        """A new guest: a real account, bound to nothing but the session that is opened for it. Raises TooMany."""
        with self.database.write() as db:
            limits.take_token(db, f"guest:{address}", self.settings.guest_bucket, TOO_MANY_GUESTS)
            account = Account(role=Role.guest, name=GUEST_NAME)
            db.add(account)
            db.flush()
            return self._open_session(db, account)

    async def sign_up(
        self, wanted: NewAccount, *, visitor: Account | None, address: str, invitation: str | None = None
    ) -> OpenedSession:
        """Makes a named account: a guest `visitor` becomes it, with its work. `invitation` gives its role.

        What costs nothing is looked at before the password is hashed. Raises RefusedForm, NotFound, Conflict, TooMany
        or Crowded.
        """
        await run_in_threadpool(self._may_sign_up, wanted, address, invitation)
        hashed = await self.hashing.hash(wanted.password, address=address)
        return await run_in_threadpool(self._enter, wanted, hashed, visitor, invitation)

    def _may_sign_up(self, wanted: NewAccount, address: str, invitation: str | None) -> None:
        with self.database.write() as db:
            limits.take_token(db, f"sign-up:{address}", self.settings.sign_up_bucket, TOO_MANY_ACCOUNTS)
        with self.database.read() as db:
            if invitation is not None:
                links.check_invitation(db, invitation)
            _require_free(db, wanted.login)

    def _enter(self, wanted: NewAccount, hashed: str, visitor: Account | None, invitation: str | None) -> OpenedSession:
        try:
            with self.database.write() as db:
                role = Role.student if invitation is None else links.use_invitation(db, invitation)
                _require_free(db, wanted.login)
                account = _account_to_name(db, visitor)
                account.role, account.name = role, wanted.name
                account.login, account.password_hash = wanted.login, hashed
                db.flush()
                repository.delete_sessions_of(db, account.id)
                return self._open_session(db, account)
        except IntegrityError as error:  # taken by somebody else in this very moment
            raise RefusedForm({"login": TAKEN}) from error

    async def log_in(self, login: str, password: str, *, visitor: Account | None, address: str) -> OpenedSession:
        """Opens a session; a guest `visitor`'s work joins the account. Raises RefusedForm, TooMany or Crowded."""
        try:
            account = await run_in_threadpool(self._account_to_try, normalise_login(login), address)
        except RateLimited:
            REFUSED_LOGINS.add("too_many")
            raise
        stored = account.password_hash if account else None
        right = await self.hashing.verify(password, stored, address=address)
        if not right or account is None:
            REFUSED_LOGINS.add("password")
            raise RefusedForm({"password": WRONG_LOGIN})
        return await run_in_threadpool(self._come_back, account, visitor, address)

    def _account_to_try(self, login: str, address: str) -> Account | None:
        """The account whose password is going to be tried; each try is counted. Raises TooMany."""
        with self.database.write() as db:
            key = f"login:{secrets.digest(f'{login} {address}')}"
            limits.take_token(db, key, self.settings.login_bucket, TOO_MANY_LOGINS)
            limits.take_token(db, f"login-from:{address}", self.settings.guest_bucket, TOO_MANY_LOGINS)
        with self.database.read() as db:
            return repository.find_account_by_login(db, login) if is_valid_login(login) else None

    def _come_back(self, account: Account, visitor: Account | None, address: str) -> OpenedSession:
        """It was no guess: the address may try as often as before. A school's has a thousand pupils behind it."""
        with self.database.write() as db:
            limits.give_back_token(db, f"login-from:{address}")
            now = repository.find_account(db, account.id)
            if now is None or now.disabled_at is not None:
                REFUSED_LOGINS.add("disabled")
                raise RefusedForm({"password": DISABLED})
            self._bring_along(db, visitor, account.id)
            return self._open_session(db, account)

    def _bring_along(self, db: Session, visitor: Account | None, account_id: UUID) -> None:
        if visitor is not None and visitor.is_guest:
            self.adopt(db, visitor.id, account_id)
            repository.delete_account(db, visitor.id)

    async def require_password(self, account: Account, password: str, *, address: str) -> None:
        """Check the password before an action that cannot be undone. A guest has none and passes; an account that is
        no guest and has no password never passes.

        Raises RefusedForm, TooMany or Crowded.
        """
        if account.is_guest:
            return
        login = account.login
        stored = None if login is None else await run_in_threadpool(self._account_to_try, login, address)
        if not await self.hashing.verify(password, stored.password_hash if stored else None, address=address):
            raise RefusedForm({"password": WRONG_PASSWORD})

    async def change_password(self, account: Account, old: str, new: str, *, session: str, address: str) -> None:
        """Closes every other session than the one of the token `session`. Raises as `prove` does, and NotFound."""
        if account.login is None:
            raise NotFound(NO_PASSWORD)
        wanted = await run_in_threadpool(validate_new_password, new, login=account.login, name=account.name)
        await self.require_password(account, old, address=address)
        hashed = await self.hashing.hash(wanted, address=address)
        await run_in_threadpool(self._change, account.id, hashed, secrets.digest(session))

    def _change(self, account_id: UUID, hashed: str, kept: str) -> None:
        with self.database.write() as db:
            repository.set_password(db, account_id, hashed)
            repository.delete_sessions_of(db, account_id, but=kept)

    async def choose_password(
        self, token: str, password: str, *, visitor: Account | None, address: str
    ) -> OpenedSession:
        """By a one-time link: all that was open with the old password ends, API tokens too.

        Raises NotFound, Conflict, RefusedForm, TooMany or Crowded.
        """
        account = await run_in_threadpool(self._owner_of_link, token, address)
        wanted = validate_new_password(password, login=account.login or "", name=account.name)
        hashed = await self.hashing.hash(wanted, address=address)
        return await run_in_threadpool(self._choose, token, hashed, visitor)

    def _owner_of_link(self, token: str, address: str) -> Account:
        with self.database.write() as db:
            limits.take_token(db, f"login-from:{address}", self.settings.guest_bucket, TOO_MANY_LOGINS)
        with self.database.read() as db:
            return links.find_link_owner(db, token)

    def _choose(self, token: str, hashed: str, visitor: Account | None) -> OpenedSession:
        with self.database.write() as db:
            account = links.use_password_link(db, token)
            repository.set_password(db, account.id, hashed)
            repository.delete_sessions_of(db, account.id)
            repository.delete_tokens_of(db, account.id)
            self._bring_along(db, visitor, account.id)
            return self._open_session(db, account)

    def _open_session(self, db: Session, account: Account) -> OpenedSession:
        token = secrets.new_token()
        expires = utc_now() + timedelta(days=self.settings.session_days)
        db.add(BrowserSession(token_digest=secrets.digest(token), account_id=account.id, expires_at=expires))
        return OpenedSession(account, token)


def _require_free(db: Session, login: str) -> None:
    if repository.find_account_by_login(db, login) is not None:
        raise RefusedForm({"login": TAKEN})


def _account_to_name(db: Session, visitor: Account | None) -> Account:
    guest = repository.find_account(db, visitor.id) if visitor is not None and visitor.is_guest else None
    account = guest or Account(name=GUEST_NAME)
    db.add(account)
    return account


def create_for_roster(db: Session, login: str, name: str) -> Account:
    """An account of whom a school's list names. It has no password until its owner chooses one (`links.link_of`)."""
    account = Account(role=Role.student, name=name, login=login)
    db.add(account)
    db.flush()
    return account


def create_account(db: Session, login: str, name: str, role: Role) -> Account:
    """An account that an administrator makes, without a password yet. Raises RefusedForm."""
    wanted = new_account_without_password(name, login)
    _require_free(db, wanted.login)
    account = create_for_roster(db, wanted.login, wanted.name)
    account.role = role
    return account


def disable(db: Session, account: Account) -> None:
    """Nobody enters by it from now on: sessions, tokens and links end. Raises Conflict for the last administrator."""
    if account.is_administrator and account.disabled_at is None and repository.count_administrators(db) == 1:
        raise Conflict(LAST_ADMINISTRATOR)
    account.disabled_at = account.disabled_at or utc_now()
    repository.delete_sessions_of(db, account.id)
    repository.delete_tokens_of(db, account.id)
    repository.delete_password_link(db, account.id)


def enable(account: Account) -> None:
    account.disabled_at = None


def revoke_session(db: Session, account: Account, name: str) -> bool:
    """Closes the sessions of which the digest begins by this; whether there was one."""
    found = [one for one in repository.load_sessions(db, account.id) if one.token_digest.startswith(name)]
    for one in found:
        repository.delete_session(db, one.token_digest)
    return bool(found)


def change_role(db: Session, account: Account, role: Role) -> None:
    """Raises Conflict where nobody would be administrator any more."""
    counts = account.is_administrator and account.disabled_at is None
    if counts and role is not Role.administrator and repository.count_administrators(db) == 1:
        raise Conflict(LAST_ADMINISTRATOR)
    account.role = role


def rename_guest(db: Session, account: Account, name: str) -> None:
    """What a guest is called from now on; an account with a login keeps the name that its owner has chosen."""
    if account.is_guest:
        repository.rename_account(db, account.id, name)


def close_session(db: Session, token: str) -> None:
    repository.delete_session(db, secrets.digest(token))


def delete_expired(db: Session) -> None:
    """Removes sessions, API tokens and links that have ended, and token buckets that have been full for long."""
    now = utc_now()
    repository.delete_expired(db, now)
    limits.delete_stale_buckets(db, before=now - BUCKET_RETENTION)


def account_of_session(db: Session, token: str) -> Account | None:
    return repository.find_account_by_session(db, secrets.digest(token), utc_now())
