"""Guests, sign-up, log-in, passwords.

Functions that take `db` work inside the caller's transaction. Methods that hash a password are asynchronous, and wait
for it outside any transaction (`server.identity.hashing`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import timedelta
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.counters import REFUSED_LOGINS
from server.base.errors import Forbidden, NotFound, RateLimited
from server.base.settings import Settings
from server.base.turns import record_sender
from server.database import Database, utc_now
from server.identity import devices, identities, links, repository, secrets, tokens
from server.identity.hashing import KNOWN, NOBODY, PasswordHasher
from server.identity.links import LinkCheck
from server.identity.login_attempts import TOO_MANY_LOGINS, CountedLoginAttempt, begin_login
from server.identity.logins import find_latin_look_alike
from server.identity.models import Account, ApiToken, BrowserSession, Role
from server.identity.opened_sessions import (
    AdoptGuestData,
    JoinCheck,
    OpenedSession,
    PasswordProof,
    RecordInvited,
    SessionOrigin,
    accept_every_join,
    record_nothing,
)
from server.identity.schemas import NewAccount, RefusedForm, validate_new_password, validate_token_label
from server.limits import service as limits

BUCKET_RETENTION = timedelta(days=7)
GUEST_NAME = "Invité"
#: The form reveals that a login exists: the rate limit of sign-ups makes enumeration slow.
TAKEN = "Cet identifiant n’est pas disponible : choisissez-en un autre, ou connectez-vous si c’est le vôtre."
WRONG_PASSWORD = "Ce n’est pas votre mot de passe actuel."
GUEST_TOKEN = (
    "Un jeton se crée avec un mot de passe, et un invité n’en a pas : créez un compte, qui garde votre travail, puis "
    "revenez ici."
)
NO_PASSWORD = "Ce compte n’a pas de mot de passe."
TOO_MANY_ACCOUNTS = "Trop de comptes créés depuis cette adresse : réessayez dans {seconds} s."
DISABLED = "Ce compte est suspendu : adressez-vous à qui administre ce serveur."
WRONG_LOGIN = "Identifiant ou mot de passe incorrect."
TOO_MANY_GUESTS = "Trop de nouveaux visiteurs depuis cette adresse : réessayez dans {seconds} s."


@dataclass(frozen=True)
class AccountService:
    """Sign-up, log-in and password changes. `adopt_guest_data` moves a guest's work to an account.

    `is_link_in_force` checks a link to a password against the rights of its maker and the place of its account;
    `record_invited` records who used an invitation.
    """

    database: Database
    settings: Settings
    adopt_guest_data: AdoptGuestData
    hashing: PasswordHasher = field(default_factory=PasswordHasher)
    is_link_in_force: LinkCheck = links.accept_every_link
    check_join: JoinCheck = accept_every_join
    record_invited: RecordInvited = record_nothing

    def create_guest(self, address: str) -> OpenedSession:
        """Create a guest account with a browser session. Raises RateLimited."""
        with self.database.write() as db:
            limits.take_token(db, f"guest:{address}", self.settings.guest_bucket, TOO_MANY_GUESTS)
            account = Account(role=Role.guest, name=GUEST_NAME)
            db.add(account)
            db.flush()
            return self.open_session(db, account)

    async def sign_up(
        self,
        form: NewAccount,
        *,
        visitor: Account | None,
        address: str,
        invitation: str | None = None,
        device: str = "",
    ) -> OpenedSession:
        """Create an account with a login: a guest `visitor` becomes it, with its work. `invitation` gives its role.

        Cheap checks come before the password is hashed. Raises RefusedForm, NotFound, Conflict, RateLimited
        or Overloaded.
        """
        await run_in_threadpool(self._check_sign_up, form, address, invitation)
        hashed = await self.hashing.hash(form.password, address=address, rank=NOBODY)
        return await run_in_threadpool(self._insert_account, form, hashed, visitor, invitation, device)

    def _check_sign_up(self, form: NewAccount, address: str, invitation: str | None) -> None:
        with self.database.write() as db:
            limits.take_token(db, f"sign-up:{address}", self.settings.sign_up_bucket, TOO_MANY_ACCOUNTS)
        with self.database.read() as db:
            if invitation is not None:
                links.find_open_invitation(db, invitation)
            require_login_free(db, form.login)

    def _insert_account(
        self, form: NewAccount, hashed: str, visitor: Account | None, invitation: str | None, device: str
    ) -> OpenedSession:
        try:
            with self.database.write() as db:
                role = Role.student if invitation is None else links.consume_invitation(db, invitation)
                require_login_free(db, form.login)
                account = _new_or_guest_account(db, visitor)
                account.role, account.name, account.login, account.password_hash = role, form.name, form.login, hashed
                db.flush()
                repository.delete_sessions_of(db, account.id)
                repository.delete_tokens_of(db, account.id)  # a guest's, made without a password
                if invitation is not None:
                    self.record_invited(db, account)
                return self.open_session(db, account, device)
        except IntegrityError as error:  # taken by somebody else at the same time
            raise RefusedForm({"login": TAKEN}) from error

    async def log_in(
        self, login: str, password: str, *, visitor: Account | None, address: str, device: str = ""
    ) -> OpenedSession:
        """Open a session; a guest `visitor`'s work moves to it. `device` is the token that the browser shows.

        Raises RefusedForm, RateLimited or Overloaded.
        """
        account, buckets = await self.verify_login(login, password, address=address, device=device)
        return await run_in_threadpool(self._open_after_login, account, visitor, buckets, device)

    async def verify_login(
        self, login: str, password: str, *, address: str, device: str = ""
    ) -> tuple[Account, Sequence[str]]:
        """Return the account of a login with a correct password, and the token buckets to give back to.

        Raises RefusedForm, RateLimited or Overloaded.
        """
        try:
            attempt = await run_in_threadpool(self._begin_login, login, address, device)
        except RateLimited:
            REFUSED_LOGINS.add("too_many")
            raise
        account = attempt.account
        if account is not None or not attempt.seconds_refused:
            stored = account.password_hash if account else None
            is_correct = await self.hashing.verify(
                password, stored, address=address, rank=attempt.rank, login=attempt.login
            )
            if is_correct and account is not None:
                return account, attempt.buckets
        if attempt.seconds_refused:
            REFUSED_LOGINS.add("too_many")
            raise await attempt.delayed_refusal()
        REFUSED_LOGINS.add("password")
        raise RefusedForm({"password": WRONG_LOGIN})

    def _begin_login(self, login: str, address: str, device: str) -> CountedLoginAttempt:
        with self.database.write() as db:
            return begin_login(db, self.settings, login, address, device)

    def _open_after_login(
        self, account: Account, visitor: Account | None, buckets: Sequence[str], device: str
    ) -> OpenedSession:
        """Open a session after a correct password, and give back the tokens taken: a school shares one address."""
        with self.database.write() as db:
            for key in buckets:
                limits.give_back_token(db, key)
            current = repository.lock_account(db, account.id)
            if current is not None and current.password_hash != account.password_hash:
                raise RefusedForm({"password": WRONG_LOGIN})  # changed meanwhile
            if current is None or current.disabled_at is not None:
                REFUSED_LOGINS.add("disabled")
                raise RefusedForm({"password": DISABLED})
            self.adopt_guest(db, visitor, account.id)
            return self.open_session(db, account, device)

    def adopt_guest(self, db: Session, visitor: Account | None, account_id: UUID) -> None:
        if visitor is not None and visitor.is_guest:
            self.adopt_guest_data(db, visitor.id, account_id)
            repository.delete_account(db, visitor.id)

    async def require_password(
        self, account: Account, password: str, *, credential: str, address: str
    ) -> PasswordProof | None:
        """Check the password, typed again, before an action that cannot be undone or that gives a credential.

        `credential` is the session or API token of the request: each has tries of its own, so that nobody else uses
        them up. A guest has no password and passes (None). Another account without a password passes where an identity
        in another system has just opened the session, and never else. Raises RefusedForm, RateLimited or Overloaded.
        """
        if account.is_guest:
            return None
        stored, is_fresh = await run_in_threadpool(self._load_stored_password, account.id, credential)
        if stored is None:
            if not is_fresh:
                raise RefusedForm({"password": identities.SIGN_IN_AGAIN})
            return PasswordProof(account.id, None)
        if not await self.hashing.verify(password, stored, address=address, rank=KNOWN):
            raise RefusedForm({"password": WRONG_PASSWORD})
        return PasswordProof(account.id, stored)

    def _load_stored_password(self, account_id: UUID, credential: str) -> tuple[str | None, bool]:
        """Return the stored hash of an account, and whether `credential` is a session that proves who it is."""
        token_digest = secrets.sha256_hex(credential)
        with self.database.write() as db:
            limits.take_token(db, f"password:{token_digest}", self.settings.login_bucket, TOO_MANY_LOGINS)
            account = repository.find_account(db, account_id)
            session = repository.find_session(db, token_digest, utc_now())
            stored = account.password_hash if account is not None else None
            return stored, identities.is_recent_identity_session(session, account_id)

    async def create_token(
        self, account: Account, label: str, password: str, *, session: str, address: str
    ) -> tuple[ApiToken, str]:
        """Create an API token after the password was typed again. Raises Forbidden for a guest, and as
        `require_password`."""
        if account.is_guest:
            raise Forbidden(GUEST_TOKEN)
        name = validate_token_label(label)
        proof = await self.require_password(account, password, credential=session, address=address)
        return await run_in_threadpool(self._insert_token, proof, name)

    def _insert_token(self, proof: PasswordProof | None, label: str) -> tuple[ApiToken, str]:
        with self.database.write() as db:
            return tokens.create_token(db, _require_proof_still_valid(db, proof), label, self.settings)

    async def change_password(self, account: Account, old: str, new: str, *, session: str, address: str) -> None:
        """Change a password; end all API tokens, and all sessions but that of the token `session`.

        Raises as `require_password`, and NotFound.
        """
        if account.login is None:
            raise NotFound(NO_PASSWORD)
        form = await run_in_threadpool(validate_new_password, new, login=account.login, name=account.name)
        proof = await self.require_password(account, old, credential=session, address=address)
        hashed = await self.hashing.hash(form, address=address, rank=KNOWN)
        await run_in_threadpool(self._store_new_password, proof, hashed, secrets.sha256_hex(session))

    def _store_new_password(self, proof: PasswordProof | None, hashed: str, session_digest: str) -> None:
        with self.database.write() as db:
            account = _require_proof_still_valid(db, proof)
            repository.set_password(db, account.id, hashed)
            repository.delete_sessions_of(db, account.id, keep=session_digest)
            repository.delete_tokens_of(db, account.id)

    async def choose_password(
        self, token: str, password: str, *, visitor: Account | None, address: str, device: str = ""
    ) -> OpenedSession:
        """Set a password by a one-time link, which ends all sessions and API tokens.

        Raises NotFound, Conflict, RefusedForm, RateLimited or Overloaded.
        """
        account = await run_in_threadpool(self._find_link_owner_counted, token, address)
        form = validate_new_password(password, login=account.login or "", name=account.name)
        hashed = await self.hashing.hash(form, address=address, rank=KNOWN)
        return await run_in_threadpool(self._set_password_by_link, token, hashed, visitor, device)

    def _find_link_owner_counted(self, token: str, address: str) -> Account:
        with self.database.write() as db:
            limits.take_token(db, f"login-from:{address}", self.settings.guest_bucket, TOO_MANY_LOGINS)
        with self.database.read() as db:
            return links.find_link_owner(db, token, self.is_link_in_force)

    def find_link_owner(self, token: str, address: str) -> Account:
        """Return the account of a link or a typed code; wrong ones count. Raises NotFound or RateLimited."""
        owner = self._find_link_owner_counted(token, address)
        with self.database.write() as db:
            limits.give_back_token(db, f"login-from:{address}")
        return owner

    def _set_password_by_link(self, token: str, hashed: str, visitor: Account | None, device: str) -> OpenedSession:
        with self.database.write() as db:
            account = links.consume_password_link(db, token, self.is_link_in_force)
            repository.set_password(db, account.id, hashed)
            repository.delete_sessions_of(db, account.id)
            repository.delete_tokens_of(db, account.id)
            repository.delete_devices_of(db, account.id)
            self.adopt_guest(db, visitor, account.id)
            return self.open_session(db, account, device)

    def open_session(
        self, db: Session, account: Account, device: str | None = None, origin: SessionOrigin | None = None
    ) -> OpenedSession:
        """Open a session; with `device`, the token that the browser shows or an empty text, it is known from now on."""
        token, now, source = secrets.draw_secret_token(), utc_now(), origin or SessionOrigin()
        db.add(
            BrowserSession(
                token_digest=secrets.sha256_hex(token),
                account_id=account.id,
                expires_at=now + timedelta(days=self.settings.session_days),
                identity_id=source.identity_id,
                external_digest=source.external_digest,
                frames=source.frames,
            )
        )
        record_sender(token, account.id, is_guest=account.is_guest)
        known_as = "" if device is None else devices.remember_device(db, account.id, device, now)
        return OpenedSession(account, token, known_as, bool(source.frames))


def _require_proof_still_valid(db: Session, proof: PasswordProof | None) -> Account:
    """Lock and return the account of a proof. Raises RefusedForm where its password has changed, or it was disabled."""
    account = None if proof is None else repository.lock_account(db, proof.account_id)
    if account is None or proof is None or account.password_hash != proof.password_hash or account.disabled_at:
        raise RefusedForm({"password": WRONG_PASSWORD})
    return account


def require_login_free(db: Session, login: str) -> None:
    """Raise RefusedForm for a login that an account has, or that looks like the Latin login of one."""
    if any(repository.find_account_by_login(db, form) for form in dict.fromkeys((login, find_latin_look_alike(login)))):
        raise RefusedForm({"login": TAKEN})


def _new_or_guest_account(db: Session, visitor: Account | None) -> Account:
    guest = repository.find_account(db, visitor.id) if visitor is not None and visitor.is_guest else None
    account = guest or Account(name=GUEST_NAME)
    db.add(account)
    return account


def create_account_for_roster(db: Session, login: str, name: str) -> Account:
    """Create a student's account from a list, without a password until its owner chooses one by a link."""
    account = Account(role=Role.student, name=name, login=login)
    db.add(account)
    db.flush()
    return account


def close_session(db: Session, token: str) -> None:
    repository.delete_session(db, secrets.sha256_hex(token))


def delete_expired_credentials(db: Session) -> None:
    """Delete expired sessions, API tokens and links, and token buckets that have long been full."""
    now = utc_now()
    repository.delete_expired_credentials(db, now)
    devices.forget_stale_devices(db, now)
    limits.delete_stale_buckets(db, before=now - BUCKET_RETENTION)


def find_account_by_session_token(db: Session, token: str) -> Account | None:
    account = repository.find_account_by_session(db, secrets.sha256_hex(token), utc_now())
    if account is not None:
        record_sender(token, account.id, is_guest=account.is_guest)
    return account
