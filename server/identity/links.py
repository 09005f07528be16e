"""One-time links: the one that makes the administrator, those that lead to a new password.

Functions work inside the caller's transaction.
"""

from datetime import timedelta

from sqlalchemy.orm import Session

from server.base.errors import Conflict, NotFound
from server.base.settings import Settings
from server.database import utc_now
from server.identity import repository, secrets
from server.identity.models import Account, Invitation, Role
from server.identity.schemas import normalise_login

USED = "Ce lien a déjà servi, n’est plus valable ou n’existe pas."
ENDED = "Ce lien a déjà servi, ou n’est plus valable : demandez-en un autre à votre enseignant."


def invite_administrator(db: Session) -> str | None:
    """A fresh one-time token (older unused ones stop working), or None once there is an administrator."""
    if repository.count_administrators(db):
        return None
    repository.delete_unused_invitations(db, Role.administrator)
    token = secrets.new_token()
    db.add(Invitation(token_digest=secrets.digest(token), role=Role.administrator))
    return token


def invite(db: Session, role: Role, lasting: timedelta) -> str:
    """A one-time token by which somebody makes an account of this role; others that wait stay good."""
    token = secrets.new_token()
    db.add(Invitation(token_digest=secrets.digest(token), role=role, expires_at=utc_now() + lasting))
    return token


def check_invitation(db: Session, token: str) -> Invitation:
    """Raises NotFound."""
    invitation = repository.find_open_invitation(db, secrets.digest(token), utc_now())
    if invitation is None:
        raise NotFound(USED)
    return invitation


def use_invitation(db: Session, token: str) -> Role:
    """Raises Conflict."""
    role = repository.use_invitation(db, secrets.digest(token), utc_now())
    if role is None:
        raise Conflict(USED)
    return role


def create_reset_link(db: Session, login: str, settings: Settings) -> tuple[Account, str]:
    """Whose link it is, and its token; an earlier one of this account stops working. Raises NotFound, Conflict."""
    account = find_account_by_login(db, login)
    if account.disabled_at is not None:
        raise Conflict(f"Le compte « {account.login} » est suspendu : rétablissez-le d’abord.")
    return account, create_password_link(db, account, timedelta(hours=settings.password_link_hours))


def find_account_by_login(db: Session, login: str) -> Account:
    """Raises NotFound."""
    wanted = normalise_login(login)
    account = (
        repository.find_account_by_login(db, wanted) if wanted.isprintable() else None
    )  # no database looks for a zero byte
    if account is None:
        raise NotFound(f"Aucun compte n’a l’identifiant « {login} ».")
    return account


def create_password_link(db: Session, account: Account, lasting: timedelta) -> str:
    """The token by which this account chooses a password; an earlier one stops working."""
    token = secrets.new_token()
    repository.upsert_password_link(db, account.id, secrets.digest(token), utc_now() + lasting)
    return token


def find_link_owner(db: Session, token: str) -> Account:
    """Who may choose a new password with this link. Raises NotFound."""
    account = repository.find_account_by_link(db, secrets.digest(token), utc_now())
    if account is None:
        raise NotFound(ENDED)
    return account


def use_password_link(db: Session, token: str) -> Account:
    """The same, once: of two uses at the same time one only gets the account. Raises Conflict."""
    account_id = repository.use_password_link(db, secrets.digest(token), utc_now())
    account = None if account_id is None else repository.find_account(db, account_id)
    if account is None or account.disabled_at is not None:
        raise Conflict(ENDED)
    return account
