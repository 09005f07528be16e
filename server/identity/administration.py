"""Administrators create accounts, change their role, suspend them, close sessions. Each ends what no longer fits.

Functions work inside the caller's transaction.
"""

from sqlalchemy.orm import Session

from server.base.errors import Conflict
from server.database import utc_now
from server.identity import repository, service
from server.identity.models import Account, Role
from server.identity.schemas import new_account_without_password

LAST_ADMINISTRATOR = "Ce serveur garde au moins un administrateur : nommez-en un autre d’abord."


def create_account(db: Session, login: str, name: str, role: Role) -> Account:
    """Create an account without a password. Raises RefusedForm."""
    form = new_account_without_password(name, login)
    service.require_login_free(db, form.login)
    account = service.create_account_for_roster(db, form.login, form.name)
    account.role = role
    return account


def disable_account(db: Session, account: Account) -> None:
    """Disable an account, and end its sessions, tokens and links. Raises Conflict for the last administrator."""
    if account.is_administrator and account.disabled_at is None and repository.count_administrators(db) == 1:
        raise Conflict(LAST_ADMINISTRATOR)
    account.disabled_at = account.disabled_at or utc_now()
    repository.delete_sessions_of(db, account.id)
    repository.delete_tokens_of(db, account.id)
    repository.delete_devices_of(db, account.id)
    repository.delete_password_link(db, account.id)


def enable_account(account: Account) -> None:
    account.disabled_at = None


def revoke_sessions_by_digest_prefix(db: Session, account: Account, digest_prefix: str) -> bool:
    """Close the sessions whose digest has this prefix; return whether there was one."""
    sessions = repository.load_sessions(db, account.id)
    matching = [session for session in sessions if session.token_digest.startswith(digest_prefix)]
    for session in matching:
        repository.delete_session(db, session.token_digest)
    return bool(matching)


def change_role(db: Session, account: Account, role: Role) -> None:
    """Change an account's role, which ends its API tokens and its link to a password.

    They were made for somebody who could do other things. Raises Conflict where no administrator would remain.
    """
    counts = account.is_administrator and account.disabled_at is None
    if counts and role is not Role.administrator and repository.count_administrators(db) == 1:
        raise Conflict(LAST_ADMINISTRATOR)
    if account.role == role:
        return
    account.role = role
    revoke_role_credentials(db, account)


def revoke_role_credentials(db: Session, account: Account) -> None:
    """End the API tokens and the link to a password of an account that may do other things from now on."""
    repository.delete_tokens_of(db, account.id)
    repository.delete_password_link(db, account.id)
