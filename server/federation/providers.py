"""Providers of identities: added, changed, paused and removed by an administrator, with what each did last.

Functions work inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from uuid import UUID

from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.errors import Conflict, Forbidden, NotFound
from server.database import utc_now
from server.federation import repository
from server.federation.errors import FederationRefused
from server.federation.models import ID_LENGTH, NAME_LENGTH, IdentityProvider, Protocol
from server.federation.outgoing import is_url, origin_of_url
from server.identity.models import ISSUER_LENGTH, Account
from server.text.lines import describe_forbidden_character, normalise_line

UNKNOWN = "Cette plateforme n’existe pas, ou a été retirée."
SAME_ISSUER = (
    "Cette plateforme (« {issuer} ») est déjà inscrite avec d’autres adresses de clés : une seconde inscription "
    "pourrait nommer les comptes de la première. Retirez d’abord l’autre, ou reprenez ses adresses."
)
ALREADY = "Cette plateforme est déjà inscrite avec cet identifiant de client."
NO_ADDRESS = "Indiquez une adresse complète, en https://."
NO_TEXT = "Remplissez cette case."
ADMINISTRATORS = "Seul l’administrateur de ce serveur règle les systèmes des établissements."
LENGTHS = {"name": NAME_LENGTH, "issuer": ISSUER_LENGTH, "client_id": ID_LENGTH}


def require_administrator(account: Account) -> None:
    """Raise Forbidden for anybody else."""
    if not account.is_administrator:
        raise Forbidden(ADMINISTRATORS)


def find_provider(db: Session, provider_id: UUID, protocol: Protocol | None = None) -> IdentityProvider:
    """Raises NotFound."""
    provider = repository.find_provider(db, provider_id)
    if provider is None or (protocol is not None and provider.protocol != protocol):
        raise NotFound(UNKNOWN)
    return provider


def read_form_texts(
    form: Mapping[str, str], names: Mapping[str, int] = LENGTHS
) -> tuple[dict[str, str], dict[str, str]]:
    """Return the tidied lines of a form, of these names and longest lengths, and the problems of each."""
    texts = {name: normalise_line(form.get(name, "")) for name in names}
    problems = {
        name: NO_TEXT
        for name, text in texts.items()
        if not 0 < len(text) <= names[name] or describe_forbidden_character(text)
    }
    return texts, problems


def address_problem(text: str, *, insecure: bool = False) -> str:
    """Return why a text is no address that may be asked; empty where it is one."""
    return "" if is_url(text, insecure=insecure) else NO_ADDRESS


def is_origin(text: str, *, insecure: bool = False) -> bool:
    """Whether a text is an origin, fit for a header: nothing in it ends a directive of a policy."""
    return is_url(text, insecure=insecure) and origin_of_url(text) == text and not set(text) & set(";,'\"*")


def add_provider(db: Session, provider: IdentityProvider, by: UUID | None, *, anchor: str) -> IdentityProvider:
    """Add a provider. Raises Conflict for one that is there, or whose issuer has other proofs.

    `anchor` names the setting by which its proofs are verified: equal for all registrations of an issuer.
    """
    for other in repository.load_registrations(db, provider.issuer):
        if other.protocol != provider.protocol or other.settings.get(anchor) != provider.settings.get(anchor):
            raise Conflict(SAME_ISSUER.format(issuer=provider.issuer))
        if other.client_id == provider.client_id:
            raise Conflict(ALREADY)
    provider.created_by = by
    try:
        with db.begin_nested():
            db.add(provider)
    except IntegrityError:
        raise Conflict(ALREADY) from None
    _record(db, by, AuditAction.platform_added, provider, after=_settings_without_secrets(provider))
    return provider


def change_settings(
    db: Session, provider: IdentityProvider, by: UUID, settings: Mapping[str, Any], *, anchor: str, name: str = ""
) -> None:
    """Replace a provider's settings, and its name. Raises Conflict where another registration has other proofs."""
    for other in repository.load_registrations(db, provider.issuer):
        if other.id != provider.id and other.settings.get(anchor) != settings.get(anchor):
            raise Conflict(SAME_ISSUER.format(issuer=provider.issuer))
    before = _settings_without_secrets(provider)
    provider.settings, provider.name = dict(settings), name or provider.name
    _record(db, by, AuditAction.platform_changed, provider, before=before, after=_settings_without_secrets(provider))


def pause_provider(db: Session, provider: IdentityProvider, by: UUID) -> None:
    """Let nobody in by this provider from now on; sessions that it has opened end."""
    if provider.paused_at is None:
        provider.paused_at = utc_now()
        repository.end_issuer_sessions(db, provider.issuer)
        _record(db, by, AuditAction.platform_paused, provider)


def resume_provider(db: Session, provider: IdentityProvider, by: UUID) -> None:
    if provider.paused_at is not None:
        provider.paused_at = None
        _record(db, by, AuditAction.platform_resumed, provider)


def remove_provider(db: Session, provider: IdentityProvider, by: UUID | None) -> None:
    """Remove a provider, its courses and the states of its marks; accounts and their work stay."""
    _record(db, by, AuditAction.platform_removed, provider, before=_settings_without_secrets(provider))
    repository.delete_provider(db, provider)


def require_active(provider: IdentityProvider) -> None:
    """Raise FederationRefused for a provider that an administrator has paused."""
    if provider.paused_at is not None:
        raise FederationRefused(
            "paused", f"L’entrée par « {provider.name} » est suspendue : adressez-vous à l’administrateur."
        )


def _settings_without_secrets(provider: IdentityProvider) -> dict[str, Any]:
    plain = {key: value for key, value in provider.settings.items() if "secret" not in key}
    return {"name": provider.name, "issuer": provider.issuer, "client_id": provider.client_id, **plain}


def _record(
    db: Session,
    by: UUID | None,
    what: AuditAction,
    provider: IdentityProvider,
    before: Mapping[str, Any] | None = None,
    after: Mapping[str, Any] | None = None,
) -> None:
    audit.record_event(db, None, by, what, about=provider.name, before=before, after=after)
