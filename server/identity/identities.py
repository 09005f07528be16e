"""Identities of accounts in other systems: found by issuer and subject, never by a name or an e-mail address.

Functions work inside the caller's transaction.
"""

import secrets as random
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import timedelta
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from server.base.errors import Conflict, Forbidden
from server.database import utc_now
from server.identity import repository, secrets
from server.identity.models import Account, BrowserSession, FederatedIdentity, Role
from server.identity.schemas import NAME_LENGTH, validate_account_name
from server.text.lines import describe_forbidden_character, normalise_line

#: A session that an identity has opened so lately proves who its account is, as a password typed again does.
FRESH_SESSION = timedelta(minutes=10)
PSEUDONYM_LETTERS = 5
PSEUDONYMS = {Role.teacher: "Enseignant", Role.student: "Élève"}
ADMINISTRATOR = (
    "Un compte d’administrateur ne s’ouvre qu’avec son mot de passe : le système d’un établissement ne décide pas de "
    "qui administre ce serveur."
)
SUSPENDED = "Ce compte est suspendu : adressez-vous à qui administre ce serveur."
SIGN_IN_AGAIN = (
    "Votre compte n’a pas de mot de passe : revenez d’abord par le système de votre établissement, puis refaites ceci "
    "dans les dix minutes."
)
HAS_NAME = "Votre nom vient de votre compte ou de votre établissement : il ne se change pas ici."
OTHER_IDENTITY = "Ce compte est déjà lié à une autre identité du même système."


@dataclass(frozen=True)
class ExternalPerson:
    """A person as another system names them. `name` may be empty: then the account gets a pseudonym.

    `role` is that of a new account; an existing one keeps its own, but a student may become a teacher.
    """

    issuer: str
    subject: str
    name: str = ""
    role: Role = Role.student


def clean_name_or_empty(name: str) -> str:
    """Return a name that may be shown, or an empty text for one that is too long or cannot be written."""
    line = normalise_line(name)
    return line if 0 < len(line) <= NAME_LENGTH and not describe_forbidden_character(line) else ""


def draw_pseudonym(role: Role) -> str:
    letters = "".join(random.choice(secrets.CODE_LETTERS) for _ in range(PSEUDONYM_LETTERS))
    return f"{PSEUDONYMS.get(role, 'Élève')} {letters}"


def find_or_create_identity(db: Session, person: ExternalPerson) -> tuple[FederatedIdentity, Account]:
    """Return the identity of a person with its account, locked; both are made where nobody has this identity.

    A name that the other system tells replaces a pseudonym.
    """
    row = repository.find_identity(db, person.issuer, person.subject)
    if row is None:
        try:
            with db.begin_nested():
                return _create_identity(db, person)
        except IntegrityError:  # another request of the same person was first
            row = repository.find_identity(db, person.issuer, person.subject)
            if row is None:
                raise
    identity, account = row
    name = clean_name_or_empty(person.name)
    if account.has_pseudonym and name:
        account.name, account.has_pseudonym = name, False
    return identity, account


def _create_identity(db: Session, person: ExternalPerson) -> tuple[FederatedIdentity, Account]:
    name = clean_name_or_empty(person.name)
    account = Account(role=person.role, name=name or draw_pseudonym(person.role), has_pseudonym=not name)
    db.add(account)
    db.flush()
    identity = FederatedIdentity(account_id=account.id, issuer=person.issuer, subject=person.subject)
    db.add(identity)
    db.flush()
    return identity, account


def require_identity_may_open(account: Account) -> None:
    """Raise Forbidden for an account that no identity opens: of an administrator, or suspended."""
    if account.is_administrator:
        raise Forbidden(ADMINISTRATOR)
    if account.disabled_at is not None:
        raise Forbidden(SUSPENDED)


def promote_to_teacher(db: Session, account: Account) -> None:
    """Make a student's account a teacher's, which ends the API tokens and the link to a password of the student."""
    if account.role == Role.student:
        account.role = Role.teacher
        repository.delete_tokens_of(db, account.id)
        repository.delete_password_link(db, account.id)


def load_identities(db: Session, account_id: UUID) -> Sequence[FederatedIdentity]:
    """Load the identities of an account, oldest first."""
    return repository.load_identities(db, account_id)


def is_recent_identity_session(session: BrowserSession | None, account_id: UUID) -> bool:
    """Whether an identity has opened this session of the account within `FRESH_SESSION`."""
    if session is None or session.identity_id is None or session.account_id != account_id:
        return False
    return utc_now() - session.created_at <= FRESH_SESSION


def move_identities(db: Session, newcomer_id: UUID, account_id: UUID) -> None:
    """Give an account the identities of another one. Raises Conflict where it has one of the same system."""
    own_issuers = {identity.issuer for identity in repository.load_identities(db, account_id)}
    moved = repository.load_identities(db, newcomer_id)
    if own_issuers & {identity.issuer for identity in moved}:
        raise Conflict(OTHER_IDENTITY)
    for identity in moved:
        identity.account_id = account_id
    db.flush()


def replace_pseudonym(db: Session, account: Account, name: str) -> None:
    """Name an account that has a pseudonym, as its owner wants. Raises RefusedForm or Conflict."""
    current = repository.lock_account(db, account.id)
    if current is None or not current.has_pseudonym:
        raise Conflict(HAS_NAME)
    current.name = validate_account_name(name)


def rename_guest(db: Session, account: Account, name: str) -> None:
    """Rename a guest; an account with a login keeps the name that its owner chose."""
    if account.is_guest:
        repository.rename_account(db, account.id, name)
