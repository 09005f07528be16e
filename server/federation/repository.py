"""Queries on providers, their courses and activity, sign-ins that have begun, keys, line items and marks to send."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from datetime import datetime
from typing import Any
from uuid import UUID, uuid4

from sqlalchemy import delete, func, or_, select, update
from sqlalchemy.orm import Session

from server.assignments.models import Assignment
from server.classes.models import SchoolClass
from server.database import upsert_statement
from server.federation.models import (
    REASON_LENGTH,
    ActivityKind,
    ContextTeacher,
    DeliveryState,
    IdentityProvider,
    LineItem,
    MarkDelivery,
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


def load_buttons(db: Session) -> Sequence[IdentityProvider]:
    """Load the providers by which somebody may sign in from our own page: a platform of LTI is entered from itself."""
    query = select(IdentityProvider).where(
        IdentityProvider.protocol != Protocol.lti, IdentityProvider.paused_at.is_(None)
    )
    return db.execute(query.order_by(IdentityProvider.name, IdentityProvider.id)).scalars().all()


def find_provider(db: Session, provider_id: UUID) -> IdentityProvider | None:
    return db.get(IdentityProvider, provider_id)


def find_registrations(db: Session, issuer: str, client_id: str = "") -> Sequence[IdentityProvider]:
    """Load the registrations of an issuer, or the one of a client id."""
    query = select(IdentityProvider).where(IdentityProvider.issuer == issuer)
    return db.execute(query.where(IdentityProvider.client_id == client_id) if client_id else query).scalars().all()


def count_accounts(db: Session) -> Mapping[str, int]:
    """Count the identities of each issuer."""
    query = select(FederatedIdentity.issuer, func.count()).group_by(FederatedIdentity.issuer)
    return {row[0]: row[1] for row in db.execute(query)}


def delete_provider(db: Session, provider: IdentityProvider) -> None:
    """Delete a registration; the sessions that its issuer has opened end with the last one of the issuer."""
    others = [row for row in find_registrations(db, provider.issuer) if row.id != provider.id]
    if not others:
        end_issuer_sessions(db, provider.issuer)
    db.delete(provider)


def end_issuer_sessions(db: Session, issuer: str) -> None:
    identities = select(FederatedIdentity.id).where(FederatedIdentity.issuer == issuer)
    db.execute(delete(BrowserSession).where(BrowserSession.identity_id.in_(identities)))


def record_activity(
    db: Session, provider_id: UUID, kind: ActivityKind, now: datetime, detail: str = "", *, succeeded: bool = True
) -> None:
    row = {"at": now, "detail": detail[:REASON_LENGTH]}
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


def use_registration_link(db: Session, token_digest: str, now: datetime) -> UUID | None:
    """Delete a link, and return who made it, in one statement: of several uses at once one succeeds."""
    statement = delete(RegistrationLink).where(
        RegistrationLink.token_digest == token_digest, RegistrationLink.expires_at > now
    )
    return db.execute(statement.returning(RegistrationLink.created_by)).scalar_one_or_none()


def find_pending(db: Session, state_digest: str, now: datetime) -> PendingSignIn | None:
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


def consume_pending(
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


def load_line_items(db: Session, context_id: UUID) -> Sequence[tuple[LineItem, Assignment]]:
    """Load the line items of a context whose assignments are not removed, in the order of the assignments."""
    query = (
        select(LineItem, Assignment)
        .join(Assignment, Assignment.id == LineItem.assignment_id)
        .where(LineItem.context_id == context_id, Assignment.removed_at.is_(None))
        .order_by(Assignment.opens_at, Assignment.id)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def find_line_item(db: Session, context_id: UUID, assignment_id: UUID) -> LineItem | None:
    query = select(LineItem).where(LineItem.context_id == context_id, LineItem.assignment_id == assignment_id)
    return db.execute(query).scalar_one_or_none()


def add_line_item(db: Session, context_id: UUID, assignment_id: UUID, now: datetime) -> None:
    """Add a line item, unless there is one; its gradebook is compared at once."""
    statement = upsert_statement(db, LineItem).values(
        id=uuid4(), context_id=context_id, assignment_id=assignment_id, problem="", check_at=now, created_at=now
    )
    db.execute(statement.on_conflict_do_update(index_elements=["context_id", "assignment_id"], set_={"check_at": now}))


def take_due_contexts(db: Session, now: datetime, next_check: datetime) -> Sequence[UUID]:
    """Return the contexts with line items to compare, and put their next comparison off, in one statement: one process
    takes each."""
    open_contexts = (
        select(ProviderContext.id)
        .join(SchoolClass, SchoolClass.id == ProviderContext.class_id)
        .join(IdentityProvider, IdentityProvider.id == ProviderContext.provider_id)
        .where(IdentityProvider.paused_at.is_(None))
    )
    statement = (
        update(LineItem)
        .where(LineItem.check_at <= now, LineItem.context_id.in_(open_contexts))
        .values(check_at=next_check)
        .returning(LineItem.context_id)
        .execution_options(synchronize_session=False)
    )
    return sorted(set(db.execute(statement).scalars()))


def load_deliveries(db: Session, line_item_ids: Collection[UUID]) -> Mapping[tuple[UUID, UUID], MarkDelivery]:
    query = select(MarkDelivery).where(MarkDelivery.line_item_id.in_(line_item_ids))
    return {(row.line_item_id, row.account_id): row for row in db.execute(query).scalars()}


def load_due_deliveries(
    db: Session, line_item_ids: Collection[UUID], issuer: str, now: datetime, limit: int
) -> Sequence[tuple[MarkDelivery, str]]:
    """Load deliveries that wait and are due, each with its account's subject."""
    query = (
        select(MarkDelivery, FederatedIdentity.subject)
        .join(FederatedIdentity, FederatedIdentity.account_id == MarkDelivery.account_id)
        .where(
            MarkDelivery.line_item_id.in_(line_item_ids),
            MarkDelivery.state == DeliveryState.waiting,
            MarkDelivery.next_try_at <= now,
            FederatedIdentity.issuer == issuer,
        )
        .order_by(MarkDelivery.next_try_at, MarkDelivery.account_id)
        .limit(limit)
    )
    return [(row[0], row[1]) for row in db.execute(query)]


def find_next_try(db: Session, line_item_ids: Collection[UUID]) -> datetime | None:
    """Return when the next delivery that waits is due."""
    query = select(func.min(MarkDelivery.next_try_at)).where(
        MarkDelivery.line_item_id.in_(line_item_ids), MarkDelivery.state == DeliveryState.waiting
    )
    return db.execute(query).scalar_one_or_none()


def send_again(db: Session, line_item_ids: Collection[UUID], account_id: UUID | None, now: datetime) -> int:
    """Have refused deliveries, and those that wait, sent again at once; return how many."""
    statement = (
        update(MarkDelivery)
        .where(
            MarkDelivery.line_item_id.in_(line_item_ids),
            or_(MarkDelivery.state != DeliveryState.sent, MarkDelivery.account_id == account_id),
        )
        .values(state=DeliveryState.waiting, reason="", tries=0, next_try_at=now)
        .returning(MarkDelivery.account_id)
        .execution_options(synchronize_session=False)
    )
    if account_id is not None:
        statement = statement.where(MarkDelivery.account_id == account_id)
    db.execute(update(LineItem).where(LineItem.id.in_(line_item_ids)).values(problem="", check_at=now))
    return len(db.execute(statement).all())
