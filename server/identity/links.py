"""One-time links: invitations, and links to a new password.

Functions work inside the caller's transaction.
"""

from collections.abc import Callable
from datetime import timedelta
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import Conflict, NotFound
from server.base.settings import Settings
from server.database import utc_now
from server.identity import repository, secrets
from server.identity.models import Account, Invitation, PasswordLink, Role
from server.text.lines import normalise_line

USED = "Ce lien a déjà servi, n’est plus valable ou n’existe pas."
NO_LOGIN = "« {name} » n’a pas d’identifiant ici : cette personne arrive par le système de son établissement."
ENDED = "Ce lien a déjà servi, ou n’est plus valable : demandez-en un autre à votre enseignant."


def create_administrator_invitation(db: Session) -> str | None:
    """Return a new one-time token, which replaces unused ones, or None once there is an administrator."""
    if repository.count_administrators(db):
        return None
    repository.delete_unused_invitations(db, Role.administrator)
    token = secrets.draw_secret_token()
    db.add(Invitation(token_digest=secrets.sha256_hex(token), role=Role.administrator))
    return token


def create_invitation(db: Session, role: Role, lifetime: timedelta) -> str:
    """Return a one-time token that creates an account of this role; earlier ones stay valid."""
    token = secrets.draw_secret_token()
    db.add(Invitation(token_digest=secrets.sha256_hex(token), role=role, expires_at=utc_now() + lifetime))
    return token


def find_open_invitation(db: Session, token: str) -> Invitation:
    """Return an invitation that is still open. Raises NotFound."""
    invitation = repository.find_open_invitation(db, secrets.sha256_hex(token), utc_now())
    if invitation is None:
        raise NotFound(USED)
    return invitation


def consume_invitation(db: Session, token: str) -> Role:
    """Use an invitation up, and return its role. Raises Conflict."""
    role = repository.mark_invitation_used(db, secrets.sha256_hex(token), utc_now())
    if role is None:
        raise Conflict(USED)
    return role


def create_reset_link(db: Session, login: str, settings: Settings) -> tuple[Account, str]:
    """Create a link to a new password; an earlier one stops working. Raises NotFound or Conflict."""
    account = find_account_by_login_or_id(db, login)
    if account.login is None:
        raise Conflict(NO_LOGIN.format(name=account.name))
    if account.disabled_at is not None:
        raise Conflict(f"Le compte « {account.login} » est suspendu : rétablissez-le d’abord.")
    return account, create_password_link(db, account, timedelta(hours=settings.password_link_hours))


def find_account_by_login_or_id(db: Session, typed_login: str) -> Account:
    """Return the account with this login, or with this id: not all have a login. Raises NotFound."""
    account = repository.find_account_by_typed_login(db, typed_login) or _find_account_by_typed_id(db, typed_login)
    if account is None:
        raise NotFound(f"Aucun compte n’a l’identifiant « {normalise_line(typed_login)[:60]} ».")
    return account


def _find_account_by_typed_id(db: Session, typed: str) -> Account | None:
    """Return the account with this id, unless it is a guest's."""
    try:
        account = repository.find_account(db, UUID(normalise_line(typed)))
    except ValueError:
        return None
    return account if account is not None and not account.is_guest else None


def create_password_link(
    db: Session,
    account: Account,
    lifetime: timedelta,
    *,
    class_id: UUID | None = None,
    made_by: UUID | None = None,
) -> str:
    """Return the token by which an account chooses a password; an earlier one stops working.

    `class_id` and `made_by` are those of a teacher's slip: it ends with their right to make it; its token is a code.
    """
    token = secrets.draw_secret_token() if class_id is None else secrets.draw_link_code()
    repository.upsert_password_link(
        db, account, secrets.sha256_hex(token), utc_now() + lifetime, class_id=class_id, made_by=made_by,
        code=None if class_id is None else token,
    )  # fmt: skip
    return token


#: Whether the reasons for which a link was made still hold (`server.rights.slips`).
LinkCheck = Callable[[Session, PasswordLink], bool]


def accept_every_link(_db: Session, _link: PasswordLink) -> bool:
    return True


def find_link_owner(db: Session, token: str, is_in_force: LinkCheck = accept_every_link) -> Account:
    """Return the account of a link that is still valid: its account has the same role, and its maker the same rights.

    Raises NotFound.
    """
    row = repository.find_link_with_account(db, secrets.sha256_hex(secrets.normalise_typed_token(token)), utc_now())
    if row is None or not is_in_force(db, row[0]):
        raise NotFound(ENDED)
    return row[1]


def consume_password_link(db: Session, token: str, is_in_force: LinkCheck = accept_every_link) -> Account:
    """Use a link up, and return its account; of two simultaneous uses only one succeeds. Raises Conflict."""
    token_digest = secrets.sha256_hex(secrets.normalise_typed_token(token))
    row = repository.find_link_with_account(db, token_digest, utc_now())
    if row is None or not is_in_force(db, row[0]):
        raise Conflict(ENDED)
    account_id = repository.consume_password_link(db, token_digest, utc_now())
    account = None if account_id is None else repository.lock_account(db, account_id)
    if account is None or account.disabled_at is not None or account.role != row[0].role:
        raise Conflict(ENDED)
    return account
