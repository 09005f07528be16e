"""A person whom a provider has proved arrives: account, session, classes.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime

from sqlalchemy.orm import Session

from server.database import utc_now
from server.federation import contexts, repository, waiting
from server.federation.models import ActivityKind, IdentityProvider, Protocol, ProviderContext
from server.federation.schemas import CourseRole, SignedPerson
from server.federation.tokens import LEEWAY
from server.identity import joining
from server.identity import repository as identity
from server.identity.identities import ExternalPerson, clean_name_or_empty
from server.identity.models import Account, Role
from server.identity.opened_sessions import OpenedSession
from server.identity.secrets import sha256_hex
from server.identity.service import AccountService

ROLE_WORDS: Mapping[CourseRole, str] = {
    CourseRole.student: "élève",
    CourseRole.assistant: "assistant",
    CourseRole.teacher: "enseignant",
    CourseRole.none: "aucun dans un cours",
}


@dataclass(frozen=True)
class Arrival:
    """The session of somebody who has arrived. `is_new`: the account was made now. `contexts` are their courses."""

    opened: OpenedSession
    is_new: bool
    contexts: tuple[ProviderContext, ...]


def open_session(
    db: Session,
    accounts: AccountService,
    provider: IdentityProvider,
    person: SignedPerson,
    visitor: Account | None,
    *,
    frames: str = "",
) -> Arrival:
    """Open a session for a person, and let them into the classes of their courses. Raises Forbidden."""
    external = external_person(provider, person)
    is_new = identity.find_identity(db, provider.issuer, person.subject) is None
    session = session_digest(provider, person.session) if person.session else ""
    opened = joining.open_identity_session(accounts, db, external, visitor, external=session, frames=frames)
    entered = tuple(
        contexts.store_context_and_enrol(db, provider, context, opened.account, person) for context in person.contexts
    )
    if provider.protocol != Protocol.lti:  # whose launches tell of one course each
        waiting.forget_left_contexts(db, provider.id, opened.account.id, [context.id for context in entered])
    repository.record_activity(db, provider.id, ActivityKind.sign_in, utc_now(), f"rôle : {ROLE_WORDS[person.role]}")
    return Arrival(opened, is_new, entered)


def external_person(provider: IdentityProvider, person: SignedPerson) -> ExternalPerson:
    """Return a person as an account is made of them: a teacher only where their provider is trusted with it."""
    name = clean_name_or_empty(person.name) or clean_name_or_empty(f"{person.given_name} {person.family_name}")
    teaches = provider.trusts_teachers and person.role is CourseRole.teacher
    return ExternalPerson(provider.issuer, person.subject, name, Role.teacher if teaches else Role.student)


def session_digest(provider: IdentityProvider, name: str) -> str:
    """Return the digest of a session's name in its provider: another provider's of the same name is another one."""
    return sha256_hex(f"{provider.id} {name}")


def end_sessions(db: Session, provider: IdentityProvider, name: str) -> int:
    """End the sessions that a provider has opened under this name; return how many."""
    ended = identity.delete_external_sessions(db, session_digest(provider, name))
    repository.record_activity(db, provider.id, ActivityKind.logout, utc_now(), f"{ended} session")
    return ended


def end_person_sessions(db: Session, provider: IdentityProvider, subject: str, until: float) -> int:
    """End the sessions of a person that this provider's issuer had opened by then, in seconds since the epoch; return
    how many. A later sign-in stays: an order to log out that comes twice ends nothing more."""
    moment = datetime.fromtimestamp(min(until + LEEWAY, time.time()), UTC)
    ended = identity.delete_identity_sessions(db, provider.issuer, subject, moment)
    repository.record_activity(db, provider.id, ActivityKind.logout, utc_now(), f"{ended} session")
    return ended
