"""Queries on accounts, browser sessions, API tokens, invitations and links to a new password."""

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID

from sqlalchemy import ColumnElement, Select, and_, delete, func, or_, select, update
from sqlalchemy.orm import Session

from server.database import detached_instances, prepared_statement, select_core, table_of, upsert_statement, utc_now
from server.identity.logins import is_valid_login, normalise_login, unfolded_login
from server.identity.models import (
    Account,
    ApiToken,
    BrowserSession,
    FederatedIdentity,
    Invitation,
    KnownDevice,
    PasswordLink,
    Role,
)
from server.text.lines import normalise_line

_enabled = Account.disabled_at.is_(None)


def find_account(db: Session, account_id: UUID) -> Account | None:
    return db.get(Account, account_id)


def find_account_by_login(db: Session, login: str) -> Account | None:
    return db.execute(select(Account).where(Account.login == login)).scalar_one_or_none()


def find_account_by_typed_login(db: Session, typed: str) -> Account | None:
    """Return the account of a login as somebody types it: as stored before folding, else folded."""
    forms = dict.fromkeys((unfolded_login(typed), normalise_login(typed)))
    accounts = (find_account_by_login(db, login) for login in forms if is_valid_login(login))
    return next(filter(None, accounts), None)


#: On the hot path of every request: loaded as columns.
_accounts, _sessions, _tokens = table_of(Account), table_of(BrowserSession).c, table_of(ApiToken).c


@prepared_statement
def _select_account_by_session(token_digest: str, now: datetime) -> Select[*tuple[Any, ...]]:
    query = select(_accounts).join(_sessions.token_digest.table, _sessions.account_id == _accounts.c.id)
    conditions = (_sessions.token_digest == token_digest, _sessions.expires_at > now)
    return query.where(*conditions, _accounts.c.disabled_at.is_(None))


def find_account_by_session(db: Session, token_digest: str, now: datetime) -> Account | None:
    """Return the account of a browser session, as a detached object."""
    row = select_core(db, *_select_account_by_session(token_digest, now)).one_or_none()
    return None if row is None else next(detached_instances(Account, [row]))[0]


@prepared_statement
def _select_account_by_api_token(token_digest: str, now: datetime) -> Select[*tuple[Any, ...]]:
    query = select(_accounts, _tokens.last_used_at).join(_tokens.id.table, _tokens.account_id == _accounts.c.id)
    conditions = (_tokens.token_digest == token_digest, _tokens.expires_at > now)
    return query.where(*conditions, _accounts.c.disabled_at.is_(None))


def find_account_by_token(db: Session, token_digest: str, now: datetime) -> tuple[Account, datetime | None] | None:
    """Return the account of an API token, as a detached object, and when the token was last used."""
    row = select_core(db, *_select_account_by_api_token(token_digest, now)).one_or_none()
    if row is None:
        return None
    account, (last_used_at,) = next(detached_instances(Account, [row]))
    return account, last_used_at


def update_token_last_use(db: Session, token_digest: str, now: datetime) -> None:
    db.execute(update(ApiToken).where(ApiToken.token_digest == token_digest).values(last_used_at=now))


def lock_account(db: Session, account_id: UUID) -> Account | None:
    """Lock and reload an account until the commit; None where it exists no more."""
    query = select(Account).where(Account.id == account_id).with_for_update().execution_options(populate_existing=True)
    return db.execute(query).scalar_one_or_none()


def count_accounts(db: Session) -> int:
    return db.execute(select(func.count()).select_from(Account)).scalar_one()


def count_administrators(db: Session) -> int:
    query = select(func.count()).select_from(Account).where(Account.role == Role.administrator, _enabled)
    return db.execute(query).scalar_one()


def search_accounts(db: Session, *, role: Role | None, search: str, limit: int) -> Sequence[Account]:
    """Return accounts that are no guests, sorted by login, then those without login by name: of a role, and whose login
    or name contains a text."""
    order = (Account.login.is_(None), Account.login, Account.name, Account.id)
    query = select(Account).where(Account.role != Role.guest).order_by(*order).limit(limit)
    if role is not None:
        query = query.where(Account.role == role)
    search = normalise_line(search)
    if search:
        matches = (column.icontains(search, autoescape=True) for column in (Account.login, Account.name))
        query = query.where(or_(*matches))
    return db.execute(query).scalars().all()


def delete_session(db: Session, token_digest: str) -> None:
    db.execute(delete(BrowserSession).where(BrowserSession.token_digest == token_digest))


def delete_sessions_of(db: Session, account_id: UUID, keep: str = "") -> None:
    """Delete all sessions of an account, but the one with the digest `keep`."""
    db.execute(
        delete(BrowserSession).where(BrowserSession.account_id == account_id, BrowserSession.token_digest != keep)
    )


def is_device_known(db: Session, token_digest: str, account_id: UUID) -> bool:
    query = select(KnownDevice.account_id).where(KnownDevice.token_digest == token_digest)
    return db.execute(query.where(KnownDevice.account_id == account_id)).first() is not None


def does_device_exist(db: Session, token_digest: str) -> bool:
    query = select(KnownDevice.account_id).where(KnownDevice.token_digest == token_digest)
    return db.execute(query.limit(1)).first() is not None


def upsert_device(db: Session, token_digest: str, account_id: UUID, now: datetime) -> None:
    statement = upsert_statement(db, KnownDevice).values(token_digest=token_digest, account_id=account_id, seen_at=now)
    key = ["token_digest", "account_id"]
    db.execute(statement.on_conflict_do_update(index_elements=key, set_={"seen_at": now}))


def load_devices(db: Session, account_id: UUID) -> Sequence[KnownDevice]:
    """Load the known browsers of an account, the latest log-in first."""
    query = select(KnownDevice).where(KnownDevice.account_id == account_id)
    return db.execute(query.order_by(KnownDevice.seen_at.desc(), KnownDevice.token_digest)).scalars().all()


def delete_devices_beyond(db: Session, account_id: UUID, most: int) -> None:
    """Delete all known browsers of an account but the `most` that logged in last."""
    for device in load_devices(db, account_id)[most:]:
        db.delete(device)


def delete_devices_of(db: Session, account_id: UUID) -> None:
    db.execute(delete(KnownDevice).where(KnownDevice.account_id == account_id))


def delete_stale_devices(db: Session, before: datetime) -> None:
    db.execute(delete(KnownDevice).where(KnownDevice.seen_at < before))


def find_identity(db: Session, issuer: str, subject: str) -> tuple[FederatedIdentity, Account] | None:
    """Return an identity with its account, which is locked until the commit."""
    query = (
        select(FederatedIdentity, Account)
        .join(Account, Account.id == FederatedIdentity.account_id)
        .where(FederatedIdentity.issuer == issuer, FederatedIdentity.subject == subject)
        .with_for_update(of=Account)
        .execution_options(populate_existing=True)
    )
    row = db.execute(query).one_or_none()
    return None if row is None else (row[0], row[1])


def load_identities(db: Session, account_id: UUID) -> Sequence[FederatedIdentity]:
    query = select(FederatedIdentity).where(FederatedIdentity.account_id == account_id)
    return db.execute(query.order_by(FederatedIdentity.created_at, FederatedIdentity.id)).scalars().all()


def find_session(db: Session, token_digest: str, now: datetime) -> BrowserSession | None:
    """Return a session that has not expired."""
    query = select(BrowserSession).where(BrowserSession.token_digest == token_digest, BrowserSession.expires_at > now)
    return db.execute(query).scalar_one_or_none()


def delete_external_sessions(db: Session, external_digest: str) -> int:
    """Delete the sessions of this name in the system that opened them; return how many."""
    statement = delete(BrowserSession).where(BrowserSession.external_digest == external_digest)
    return len(db.execute(statement.returning(BrowserSession.token_digest)).all())


def delete_identity_sessions(db: Session, issuer: str, subject: str, opened_until: datetime) -> int:
    """Delete the sessions that an identity had opened by then; return how many."""
    identities = select(FederatedIdentity.id).where(
        FederatedIdentity.issuer == issuer, FederatedIdentity.subject == subject
    )
    statement = delete(BrowserSession).where(
        BrowserSession.identity_id.in_(identities), BrowserSession.created_at <= opened_until
    )
    ended = statement.returning(BrowserSession.token_digest).execution_options(synchronize_session=False)
    return len(db.execute(ended).all())


def load_sessions(db: Session, account_id: UUID) -> Sequence[BrowserSession]:
    query = select(BrowserSession).where(BrowserSession.account_id == account_id)
    return db.execute(query.order_by(BrowserSession.created_at)).scalars().all()


def set_password(db: Session, account_id: UUID, password_hash: str) -> None:
    """Set a password, and delete the account's link to a new one."""
    db.execute(update(Account).where(Account.id == account_id).values(password_hash=password_hash))
    db.execute(delete(PasswordLink).where(PasswordLink.account_id == account_id))


def rename_account(db: Session, account_id: UUID, name: str) -> None:
    db.execute(update(Account).where(Account.id == account_id).values(name=name))


def delete_account(db: Session, account_id: UUID) -> None:
    db.execute(delete(Account).where(Account.id == account_id))


def load_valid_tokens(db: Session, account_id: UUID, now: datetime) -> Sequence[ApiToken]:
    query = select(ApiToken).where(ApiToken.account_id == account_id, ApiToken.expires_at > now)
    return db.execute(query.order_by(ApiToken.created_at)).scalars().all()


def load_all_tokens(db: Session, account_id: UUID) -> Sequence[ApiToken]:
    """Load an account's tokens, expired ones that are not deleted yet included."""
    query = select(ApiToken).where(ApiToken.account_id == account_id)
    return db.execute(query.order_by(ApiToken.created_at)).scalars().all()


def count_tokens(db: Session, account_id: UUID) -> int:
    query = select(func.count()).select_from(ApiToken).where(ApiToken.account_id == account_id)
    return db.execute(query).scalar_one()


def delete_expired_tokens(db: Session, account_id: UUID, now: datetime) -> None:
    db.execute(delete(ApiToken).where(ApiToken.account_id == account_id, ApiToken.expires_at <= now))


def delete_tokens_of(db: Session, account_id: UUID) -> None:
    db.execute(delete(ApiToken).where(ApiToken.account_id == account_id))


def delete_expired_credentials(db: Session, now: datetime) -> None:
    """Delete all expired sessions, tokens, links and invitations."""
    for table in (BrowserSession, ApiToken, PasswordLink):
        db.execute(delete(table).where(table.expires_at < now))
    db.execute(delete(Invitation).where(Invitation.expires_at < now, Invitation.used_at.is_(None)))


def upsert_password_link(
    db: Session,
    account: Account,
    token_digest: str,
    expires_at: datetime,
    *,
    class_id: UUID | None = None,
    made_by: UUID | None = None,
    code: str | None = None,
) -> None:
    """Store a link, replacing the account's earlier one."""
    row = {"token_digest": token_digest, "created_at": utc_now(), "expires_at": expires_at}
    row |= {"role": account.role, "class_id": class_id, "made_by": made_by, "code": code}
    statement = upsert_statement(db, PasswordLink).values(account_id=account.id, **row)
    db.execute(statement.on_conflict_do_update(index_elements=["account_id"], set_=row))


def load_unexpired_slip_links(
    db: Session, accounts: Collection[UUID], class_id: UUID, now: datetime
) -> Mapping[UUID, PasswordLink]:
    """Load the links with a code that have not ended, by account, of the slips of a class."""
    query = select(PasswordLink).where(
        PasswordLink.class_id == class_id, PasswordLink.code.is_not(None), PasswordLink.expires_at > now
    )
    return {link.account_id: link for link in db.execute(query).scalars() if link.account_id in accounts}


def delete_password_link(db: Session, account_id: UUID) -> None:
    db.execute(delete(PasswordLink).where(PasswordLink.account_id == account_id))


def find_link_with_account(db: Session, token_digest: str, now: datetime) -> tuple[PasswordLink, Account] | None:
    """Return a link that has not ended, with its account, whose role is still the same."""
    query = (
        select(PasswordLink, Account)
        .join(Account, PasswordLink.account_id == Account.id)
        .where(
            PasswordLink.token_digest == token_digest,
            PasswordLink.expires_at > now,
            PasswordLink.role == Account.role,
            _enabled,
        )
    )
    row = db.execute(query).one_or_none()
    return None if row is None else (row[0], row[1])


def consume_password_link(db: Session, token_digest: str, now: datetime) -> UUID | None:
    """Delete a link and return its account, in one statement."""
    statement = (
        delete(PasswordLink)
        .where(PasswordLink.token_digest == token_digest, PasswordLink.expires_at > now)
        .returning(PasswordLink.account_id)
    )
    return db.execute(statement).scalar_one_or_none()


def delete_token(db: Session, account_id: UUID, token_id: UUID) -> bool:
    statement = (
        delete(ApiToken).where(ApiToken.id == token_id, ApiToken.account_id == account_id).returning(ApiToken.id)
    )
    return db.execute(statement).first() is not None


def delete_unused_invitations(db: Session, role: Role) -> None:
    db.execute(delete(Invitation).where(Invitation.role == role, Invitation.used_at.is_(None)))


def find_open_invitation(db: Session, token_digest: str, now: datetime) -> Invitation | None:
    query = select(Invitation).where(Invitation.token_digest == token_digest, _is_open_invitation(now))
    return db.execute(query).scalar_one_or_none()


def mark_invitation_used(db: Session, token_digest: str, now: datetime) -> Role | None:
    """Mark an invitation as used in one conditional statement: of two simultaneous uses only one gets the role."""
    statement = (
        update(Invitation)
        .where(Invitation.token_digest == token_digest, _is_open_invitation(now))
        .values(used_at=now)
        .returning(Invitation.role)
    )
    role = db.execute(statement).scalar_one_or_none()
    return None if role is None else Role(role)


def _is_open_invitation(now: datetime) -> ColumnElement[bool]:
    """Without an end, the first administrator's: it ends once there is one, however they came to be."""
    administrator = select(Account.id).where(Account.role == Role.administrator, _enabled)
    endless = and_(Invitation.expires_at.is_(None), or_(Invitation.role != Role.administrator, ~administrator.exists()))
    return and_(Invitation.used_at.is_(None), or_(endless, Invitation.expires_at > now))
