"""Queries on providers, their courses and activity, sign-ins that have begun, keys, line items and marks to send."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import delete, func, select, update
from sqlalchemy.orm import Session

from server.database import upsert_statement
from server.federation.models import (
    REASON_LENGTH,
    ActivityKind,
    ContextTeacher,
    IdentityProvider,
    PendingSignIn,
    Protocol,
    ProviderActivity,
    ProviderContext,
    RegistrationLink,
    SigningKey,
)
from server.identity.models import Account, BrowserSession, FederatedIdentity


def load_providers(db: Session) -> Sequence[IdentityProvider]:
    return db.execute(select(IdentityProvider).order_by(IdentityProvider.name, IdentityProvider.id)).scalars().all()


def load_sign_in_providers(db: Session) -> Sequence[IdentityProvider]:
    """Load the providers by which somebody may sign in from our own page: a platform of LTI is entered from itself."""
    query = select(IdentityProvider).where(
        IdentityProvider.protocol != Protocol.lti, IdentityProvider.paused_at.is_(None)
    )
    return db.execute(query.order_by(IdentityProvider.name, IdentityProvider.id)).scalars().all()


def find_provider(db: Session, provider_id: UUID) -> IdentityProvider | None:
    return db.get(IdentityProvider, provider_id)


def load_registrations(db: Session, issuer: str, client_id: str = "") -> Sequence[IdentityProvider]:
    """Load the registrations of an issuer, or the one of a client id."""
    query = select(IdentityProvider).where(IdentityProvider.issuer == issuer)
    return db.execute(query.where(IdentityProvider.client_id == client_id) if client_id else query).scalars().all()


def count_identities_by_issuer(db: Session) -> Mapping[str, int]:
    """Count the identities of each issuer."""
    query = select(FederatedIdentity.issuer, func.count()).group_by(FederatedIdentity.issuer)
    return {row[0]: row[1] for row in db.execute(query)}


def delete_provider(db: Session, provider: IdentityProvider) -> None:
    """Delete a registration; the sessions that its issuer has opened end with the last one of the issuer."""
    others = [row for row in load_registrations(db, provider.issuer) if row.id != provider.id]
    if not others:
        end_issuer_sessions(db, provider.issuer)
    db.delete(provider)


def end_issuer_sessions(db: Session, issuer: str) -> None:
    identities = select(FederatedIdentity.id).where(FederatedIdentity.issuer == issuer)
    db.execute(delete(BrowserSession).where(BrowserSession.identity_id.in_(identities)))


def record_activity(
    db: Session, provider_id: UUID, kind: ActivityKind, now: datetime, detail: str = "", *, succeeded: bool = True
) -> None:
    readable = "".join(
        sign if sign.isprintable() else "?" for sign in detail[:REASON_LENGTH]
    )  # others may have said it
    row = {"at": now, "detail": readable}
    statement = upsert_statement(db, ProviderActivity).values(
        provider_id=provider_id, kind=kind, succeeded=succeeded, **row
    )
    key = ["provider_id", "kind", "succeeded"]
    db.execute(statement.on_conflict_do_update(index_elements=key, set_=row))


def load_activity(db: Session, providers: Collection[UUID]) -> Sequence[ProviderActivity]:
    """Load what these providers did last, newest first."""
    query = select(ProviderActivity).where(ProviderActivity.provider_id.in_(providers))
    return db.execute(query.order_by(ProviderActivity.at.desc())).scalars().all()


def find_registration_link(db: Session, token_digest: str, now: datetime) -> RegistrationLink | None:
    query = select(RegistrationLink).where(
        RegistrationLink.token_digest == token_digest, RegistrationLink.expires_at > now
    )
    return db.execute(query).scalar_one_or_none()


def consume_registration_link(db: Session, token_digest: str, now: datetime) -> UUID | None:
    """Delete a link, and return who made it, in one statement: of several uses at once one succeeds."""
    statement = delete(RegistrationLink).where(
        RegistrationLink.token_digest == token_digest, RegistrationLink.expires_at > now
    )
    return db.execute(statement.returning(RegistrationLink.created_by)).scalar_one_or_none()


def find_pending_sign_in(db: Session, state_digest: str, now: datetime) -> PendingSignIn | None:
    query = select(PendingSignIn).where(PendingSignIn.state_digest == state_digest, PendingSignIn.expires_at > now)
    return db.execute(query).scalar_one_or_none()


def set_nonce(
    db: Session, state_digest: str, browser_digest: str, nonce_digest: str, details: Mapping[str, Any]
) -> bool:
    """Set the nonce of a sign-in that this browser has begun; return whether there is one."""
    statement = (
        update(PendingSignIn)
        .where(PendingSignIn.state_digest == state_digest, PendingSignIn.browser_digest == browser_digest)
        .values(nonce_digest=nonce_digest, details=dict(details))
        .returning(PendingSignIn.state_digest)
    )
    return db.execute(statement).first() is not None


def consume_pending_sign_in(
    db: Session, provider_id: UUID, state_digest: str, nonce_digest: str, browser_digest: str, now: datetime
) -> tuple[str, Mapping[str, Any]] | None:
    """Delete a sign-in, and return its target and details: state, nonce and browser are consumed in one statement, so
    that of any number of requests at once one succeeds."""
    statement = (
        delete(PendingSignIn)
        .where(
            PendingSignIn.state_digest == state_digest,
            PendingSignIn.provider_id == provider_id,
            PendingSignIn.nonce_digest == nonce_digest,
            PendingSignIn.browser_digest == browser_digest,
            PendingSignIn.expires_at > now,
        )
        .returning(PendingSignIn.target, PendingSignIn.details)
        .execution_options(synchronize_session=False)
    )
    row = db.execute(statement).one_or_none()
    return None if row is None else (row[0], row[1])


def delete_expired(db: Session, now: datetime) -> None:
    for table in (PendingSignIn, RegistrationLink):
        db.execute(delete(table).where(table.expires_at < now))


def lock_signing_keys(db: Session) -> None:
    """Keep others from making a key at the same time, until the commit."""
    if db.get_bind().dialect.name == "postgresql":
        db.execute(select(func.pg_advisory_xact_lock(0x62616C6B)))


def load_signing_keys(db: Session) -> Sequence[SigningKey]:
    """Load our keys, newest first."""
    return db.execute(select(SigningKey).order_by(SigningKey.created_at.desc(), SigningKey.id)).scalars().all()


def upsert_context(
    db: Session, provider_id: UUID, deployment: str, context: str, values: Mapping[str, Any]
) -> ProviderContext:
    """Store what an arrival tells of its context, and return the row."""
    key = {"provider_id": provider_id, "deployment": deployment, "context": context}
    new = {"title": "", "roster_url": "", "line_items_url": "", "scopes": [], **values}
    statement = upsert_statement(db, ProviderContext).values(id=uuid4(), **key, **new)
    db.execute(statement.on_conflict_do_update(index_elements=list(key), set_=dict(values)))
    query = select(ProviderContext).filter_by(**key).execution_options(populate_existing=True)
    return db.execute(query).scalar_one()


def find_context(db: Session, context_id: UUID) -> ProviderContext | None:
    return db.get(ProviderContext, context_id)


def load_class_contexts(db: Session, class_id: UUID) -> Sequence[tuple[ProviderContext, IdentityProvider]]:
    """Load the contexts that are tied to a class, with their providers."""
    query = (
        select(ProviderContext, IdentityProvider)
        .join(IdentityProvider, IdentityProvider.id == ProviderContext.provider_id)
        .where(ProviderContext.class_id == class_id)
        .order_by(IdentityProvider.name, ProviderContext.title, ProviderContext.id)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def remember_context_teacher(db: Session, context_id: UUID, account_id: UUID, now: datetime) -> None:
    statement = upsert_statement(db, ContextTeacher).values(context_id=context_id, account_id=account_id, seen_at=now)
    db.execute(statement.on_conflict_do_update(index_elements=["context_id", "account_id"], set_={"seen_at": now}))


def forget_context_teacher(db: Session, context_id: UUID, account_id: UUID) -> None:
    db.execute(
        delete(ContextTeacher).where(ContextTeacher.context_id == context_id, ContextTeacher.account_id == account_id)
    )


def teaches_context(db: Session, context_id: UUID, account_id: UUID) -> bool:
    return db.get(ContextTeacher, (context_id, account_id)) is not None


def load_identified_members(db: Session, issuer: str, accounts: Collection[UUID]) -> Mapping[UUID, str]:
    """Return the subject of these accounts at an issuer, by account."""
    query = select(FederatedIdentity.account_id, FederatedIdentity.subject).where(FederatedIdentity.issuer == issuer)
    return {row[0]: row[1] for row in db.execute(query) if row[0] in accounts}


def load_accounts_by_subject(db: Session, issuer: str, subjects: Collection[str]) -> Mapping[str, Account]:
    """Load the accounts of these subjects, in chunks: databases bound the number of parameters."""
    accounts: dict[str, Account] = {}
    ordered = sorted(subjects)
    for start in range(0, len(ordered), 500):
        query = (
            select(FederatedIdentity.subject, Account)
            .join(Account, Account.id == FederatedIdentity.account_id)
            .where(FederatedIdentity.issuer == issuer, FederatedIdentity.subject.in_(ordered[start : start + 500]))
        )
        accounts.update({row[0]: row[1] for row in db.execute(query)})
    return accounts
