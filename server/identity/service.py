"""Guests, sign-up, log-in, passwords.

Functions that take `db` work inside the caller's transaction. Methods that hash a password are asynchronous, and wait
for it outside any transaction (`server.identity.hashing`).
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
from server.identity.logins import latin_look_alike, normalise_login
from server.identity.models import Account, BrowserSession, Role
from server.identity.schemas import (
    NewAccount,
    RefusedForm,
    new_account_without_password,
    validate_new_password,
)
from server.limits import service as limits

BUCKET_RETENTION = timedelta(days=7)
GUEST_NAME = "Invité"
#: The form reveals that a login exists: the rate limit of sign-ups makes enumeration slow.
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


#: Moves the work of a guest (first id) to the account (second id) of the same person.
Adopt = Callable[[Session, UUID, UUID], None]


@dataclass(frozen=True)
class AccountService:
    """Sign-up, log-in and password changes. `adopt` moves a guest's work to an account."""

    database: Database
    settings: Settings
    adopt: Adopt
    hashing: PasswordHasher = field(default_factory=PasswordHasher)

    def create_guest(self, address: str) -> OpenedSession:
        """Create a guest account with a browser session. Raises RateLimited."""
        with self.database.write() as db:
            limits.take_token(db, f"guest:{address}", self.settings.guest_bucket, TOO_MANY_GUESTS)
            account = Account(role=Role.guest, name=GUEST_NAME)
            db.add(account)
            db.flush()
            return self._open_session(db, account)

    async def sign_up(
        self, form: NewAccount, *, visitor: Account | None, address: str, invitation: str | None = None
    ) -> OpenedSession:
        """Create an account with a login: a guest `visitor` becomes it, with its work. `invitation` gives its role.

        Cheap checks come before the password is hashed. Raises RefusedForm, NotFound, Conflict, RateLimited
        or Overloaded.
        """
        await run_in_threadpool(self._check_sign_up, form, address, invitation)
        hashed = await self.hashing.hash(form.password, address=address)
        return await run_in_threadpool(self._insert_account, form, hashed, visitor, invitation)

    def _check_sign_up(self, form: NewAccount, address: str, invitation: str | None) -> None:
        with self.database.write() as db:
            limits.take_token(db, f"sign-up:{address}", self.settings.sign_up_bucket, TOO_MANY_ACCOUNTS)
        with self.database.read() as db:
            if invitation is not None:
                links.check_invitation(db, invitation)
            _require_free(db, form.login)

    def _insert_account(
        self, form: NewAccount, hashed: str, visitor: Account | None, invitation: str | None
    ) -> OpenedSession:
        try:
            with self.database.write() as db:
                role = Role.student if invitation is None else links.use_invitation(db, invitation)
                _require_free(db, form.login)
                account = _new_or_guest_account(db, visitor)
                account.role, account.name = role, form.name
                account.login, account.password_hash = form.login, hashed
                db.flush()
                repository.delete_sessions_of(db, account.id)
                return self._open_session(db, account)
        except IntegrityError as error:  # taken by somebody else at the same time
            raise RefusedForm({"login": TAKEN}) from error

    async def log_in(self, login: str, password: str, *, visitor: Account | None, address: str) -> OpenedSession:
        """Open a session; a guest `visitor`'s work moves to it. Raises RefusedForm, RateLimited or Overloaded."""
        try:
            account = await run_in_threadpool(self._account_for_login, login, address)
        except RateLimited:
            REFUSED_LOGINS.add("too_many")
            raise
        stored = account.password_hash if account else None
        is_correct = await self.hashing.verify(password, stored, address=address)
        if not is_correct or account is None:
            REFUSED_LOGINS.add("password")
            raise RefusedForm({"password": WRONG_LOGIN})
        return await run_in_threadpool(self._open_after_login, account, visitor, address)

    def _account_for_login(self, login: str, address: str) -> Account | None:
        """Return the account of a login; each try counts towards the rate limits. Raises RateLimited."""
        with self.database.write() as db:
            key = f"login:{secrets.digest(f'{normalise_login(login)} {address}')}"
            limits.take_token(db, key, self.settings.login_bucket, TOO_MANY_LOGINS)
            limits.take_token(db, f"login-from:{address}", self.settings.guest_bucket, TOO_MANY_LOGINS)
        with self.database.read() as db:
            return repository.find_account_by_typed_login(db, login)

    def _open_after_login(self, account: Account, visitor: Account | None, address: str) -> OpenedSession:
        """Open a session after a correct password, and give back the address's token: a school shares one address."""
        with self.database.write() as db:
            limits.give_back_token(db, f"login-from:{address}")
            current = repository.find_account(db, account.id)
            if current is None or current.disabled_at is not None:
                REFUSED_LOGINS.add("disabled")
                raise RefusedForm({"password": DISABLED})
            self._adopt_guest(db, visitor, account.id)
            return self._open_session(db, account)

    def _adopt_guest(self, db: Session, visitor: Account | None, account_id: UUID) -> None:
        if visitor is not None and visitor.is_guest:
            self.adopt(db, visitor.id, account_id)
            repository.delete_account(db, visitor.id)

    async def require_password(self, account: Account, password: str, *, address: str) -> None:
        """Check the password before an action that cannot be undone. A guest has none and passes; an account that is
        no guest and has no password never passes.

        Raises RefusedForm, RateLimited or Overloaded.
        """
        if account.is_guest:
            return
        login = account.login
        stored = None if login is None else await run_in_threadpool(self._account_for_login, login, address)
        if not await self.hashing.verify(password, stored.password_hash if stored else None, address=address):
            raise RefusedForm({"password": WRONG_PASSWORD})

    async def change_password(self, account: Account, old: str, new: str, *, session: str, address: str) -> None:
        """Change a password, and close all sessions but that of the token `session`. Raises as `require_password`, and
        NotFound."""
        if account.login is None:
            raise NotFound(NO_PASSWORD)
        form = await run_in_threadpool(validate_new_password, new, login=account.login, name=account.name)
        await self.require_password(account, old, address=address)
        hashed = await self.hashing.hash(form, address=address)
        await run_in_threadpool(self._change, account.id, hashed, secrets.digest(session))

    def _change(self, account_id: UUID, hashed: str, session_digest: str) -> None:
        with self.database.write() as db:
            repository.set_password(db, account_id, hashed)
            repository.delete_sessions_of(db, account_id, keep=session_digest)

    async def choose_password(
        self, token: str, password: str, *, visitor: Account | None, address: str
    ) -> OpenedSession:
        """Set a password by a one-time link, which ends all sessions and API tokens.

        Raises NotFound, Conflict, RefusedForm, RateLimited or Overloaded.
        """
        account = await run_in_threadpool(self._owner_of_link, token, address)
        form = validate_new_password(password, login=account.login or "", name=account.name)
        hashed = await self.hashing.hash(form, address=address)
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
            self._adopt_guest(db, visitor, account.id)
            return self._open_session(db, account)

    def _open_session(self, db: Session, account: Account) -> OpenedSession:
        token = secrets.new_token()
        expires = utc_now() + timedelta(days=self.settings.session_days)
        db.add(BrowserSession(token_digest=secrets.digest(token), account_id=account.id, expires_at=expires))
        return OpenedSession(account, token)


def _require_free(db: Session, login: str) -> None:
    """Raise RefusedForm for a login that an account has, or that looks like the Latin login of one."""
    if any(repository.find_account_by_login(db, form) for form in dict.fromkeys((login, latin_look_alike(login)))):
        raise RefusedForm({"login": TAKEN})


def _new_or_guest_account(db: Session, visitor: Account | None) -> Account:
    guest = repository.find_account(db, visitor.id) if visitor is not None and visitor.is_guest else None
    account = guest or Account(name=GUEST_NAME)
    db.add(account)
    return account


def create_for_roster(db: Session, login: str, name: str) -> Account:
    """Create a student's account from a list, without a password until its owner chooses one by a link."""
    account = Account(role=Role.student, name=name, login=login)
    db.add(account)
    db.flush()
    return account


def create_account(db: Session, login: str, name: str, role: Role) -> Account:
    """Create an account without a password. Raises RefusedForm."""
    form = new_account_without_password(name, login)
    _require_free(db, form.login)
    account = create_for_roster(db, form.login, form.name)
    account.role = role
    return account


def disable(db: Session, account: Account) -> None:
    """Disable an account, and end its sessions, tokens and links. Raises Conflict for the last administrator."""
    if account.is_administrator and account.disabled_at is None and repository.count_administrators(db) == 1:
        raise Conflict(LAST_ADMINISTRATOR)
    account.disabled_at = account.disabled_at or utc_now()
    repository.delete_sessions_of(db, account.id)
    repository.delete_tokens_of(db, account.id)
    repository.delete_password_link(db, account.id)


def enable(account: Account) -> None:
    account.disabled_at = None


def revoke_session(db: Session, account: Account, digest_prefix: str) -> bool:
    """Close the sessions whose digest has this prefix; return whether there was one."""
    sessions = repository.load_sessions(db, account.id)
    matching = [session for session in sessions if session.token_digest.startswith(digest_prefix)]
    for session in matching:
        repository.delete_session(db, session.token_digest)
    return bool(matching)


def change_role(db: Session, account: Account, role: Role) -> None:
    """Change an account's role. Raises Conflict where no administrator would remain."""
    counts = account.is_administrator and account.disabled_at is None
    if counts and role is not Role.administrator and repository.count_administrators(db) == 1:
        raise Conflict(LAST_ADMINISTRATOR)
    account.role = role


def rename_guest(db: Session, account: Account, name: str) -> None:
    """Rename a guest; an account with a login keeps the name that its owner chose."""
    if account.is_guest:
        repository.rename_account(db, account.id, name)


def close_session(db: Session, token: str) -> None:
    repository.delete_session(db, secrets.digest(token))


def delete_expired(db: Session) -> None:
    """Delete expired sessions, API tokens and links, and token buckets that have long been full."""
    now = utc_now()
    repository.delete_expired(db, now)
    limits.delete_stale_buckets(db, before=now - BUCKET_RETENTION)


def account_of_session(db: Session, token: str) -> Account | None:
    return repository.find_account_by_session(db, secrets.digest(token), utc_now())
