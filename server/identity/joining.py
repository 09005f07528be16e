"""Sessions that an identity in another system opens, and the joining of its account to one of before."""

from __future__ import annotations

from collections.abc import Sequence
from uuid import UUID

from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.errors import Conflict
from server.database import utc_now
from server.identity import identities, repository, secrets
from server.identity.identities import ExternalPerson
from server.identity.models import Account, BrowserSession, Role
from server.identity.opened_sessions import OpenedSession, SessionOrigin
from server.identity.schemas import RefusedForm
from server.identity.service import AccountService
from server.limits import service as limits

JOIN_CHANGED = "Un des deux comptes a changé entre-temps : recommencez."
JOIN_GUEST = "Un invité n’a rien à rejoindre : connectez-vous, et son travail suit."
JOIN_WITH_PASSWORD = "Ce compte-ci a déjà un identifiant et un mot de passe : il reste un compte à part."
JOIN_SELF = "C’est le compte où vous êtes déjà."


def open_identity_session(
    accounts: AccountService,
    db: Session,
    person: ExternalPerson,
    visitor: Account | None,
    *,
    external: str = "",
    frames: str = "",
) -> OpenedSession:
    """Open a session for a person whom another system has just proved; a guest `visitor`'s work moves to it.

    An unknown person gets an account. `external` is the session's name in the other system, by which it ends
    (`identities.external_digest`); `frames` are the origins that may show it in a frame. Works inside the caller's
    transaction. Raises Forbidden.
    """
    identity, account = identities.find_or_create_identity(db, person)
    identities.require_identity_may_open(account)
    identity.seen_at = utc_now()
    if person.role is Role.teacher:
        identities.promote_to_teacher(db, account)
    accounts.adopt_guest(db, visitor, account.id)
    origin = SessionOrigin(identity.id, external or None, frames)
    return accounts.open_session(db, account, origin=origin)


async def join_newcomer_to_account(
    accounts: AccountService,
    newcomer: Account,
    login: str,
    password: str,
    *,
    session: str,
    address: str,
    device: str = "",
) -> OpenedSession:
    """Join an account that an identity has just opened to an account that its owner had before, proved by its login
    and password: the identity and the work move there, and the newcomer's account ends.

    Raises RefusedForm, Conflict, Forbidden, RateLimited or Overloaded.
    """
    await run_in_threadpool(_require_joinable, accounts, newcomer, session)
    account, buckets = await accounts.verify_login(login, password, address=address, device=device)
    return await run_in_threadpool(_move_to_joined_account, accounts, newcomer, account, buckets, session)


def _require_joinable(accounts: AccountService, newcomer: Account, session: str) -> None:
    with accounts.database.read() as db:
        _find_newcomer(db, newcomer.id, session)


def _find_newcomer(db: Session, newcomer_id: UUID, session: str) -> tuple[Account, BrowserSession]:
    """Return the account to join to another one, locked, with its session. Raises Conflict or RefusedForm."""
    newcomer = repository.lock_account(db, newcomer_id)
    opened = repository.find_session(db, secrets.sha256_hex(session), utc_now())
    if newcomer is None or opened is None:
        raise Conflict(JOIN_CHANGED)
    if newcomer.is_guest:
        raise Conflict(JOIN_GUEST)
    if newcomer.login is not None or newcomer.password_hash is not None:
        raise Conflict(JOIN_WITH_PASSWORD)
    if not identities.is_recent_identity_session(opened, newcomer.id):
        raise RefusedForm({"password": identities.SIGN_IN_AGAIN})
    return newcomer, opened


def _move_to_joined_account(
    accounts: AccountService, newcomer: Account, account: Account, buckets: Sequence[str], session: str
) -> OpenedSession:
    with accounts.database.write() as db:
        for key in buckets:
            limits.give_back_token(db, key)
        for account_id in sorted((newcomer.id, account.id)):  # in one order: no deadlock
            repository.lock_account(db, account_id)
        current, opened = _find_newcomer(db, newcomer.id, session)
        target = repository.lock_account(db, account.id)
        if target is None or target.is_guest or target.password_hash != account.password_hash:
            raise Conflict(JOIN_CHANGED)
        if target.id == current.id:
            raise Conflict(JOIN_SELF)
        identities.require_identity_may_open(target)
        accounts.check_join(db, current.id, target.id)
        origin = SessionOrigin(opened.identity_id, opened.external_digest, opened.frames)
        identities.move_identities(db, current.id, target.id)
        accounts.adopt_guest_data(db, current.id, target.id)
        repository.delete_account(db, current.id)
        return accounts.open_session(db, target, origin=origin)
