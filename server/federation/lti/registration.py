"""Registration of LTI platforms: by hand, and their deployments. Functions work inside the caller's transaction."""

from __future__ import annotations

from collections.abc import Mapping
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import InvalidFields
from server.federation import providers, repository
from server.federation.errors import FederationRefused
from server.federation.lti.schemas import MAX_DEPLOYMENTS, MAX_FRAMES, LtiSettings, lti_settings
from server.federation.models import ADDRESS_LENGTH, ID_LENGTH, IdentityProvider, Protocol
from server.federation.outgoing import origin_of_url
from server.text.lines import normalise_line

ADDRESSES = ("authorization_url", "token_url", "keys_url")
ANCHOR = "keys_url"
NOT_REGISTERED = "Cette plateforme n’est pas inscrite ici : l’administrateur de Balise peut l’ajouter."
FRAMES = "Indiquez des adresses sans chemin, comme « https://moodle.lycee.example », huit au plus."
DEPLOYMENTS = "Indiquez les numéros des déploiements, séparés par des espaces, cinquante au plus."


def parse_form(form: Mapping[str, str], *, insecure: bool = False) -> tuple[dict[str, str], LtiSettings]:
    """Return name, issuer and client id, and the settings, as an administrator has typed them. Raises InvalidFields."""
    texts, problems = providers.read_form_texts(form)
    addresses, missing = providers.read_form_texts(form, dict.fromkeys(ADDRESSES, ADDRESS_LENGTH))
    problems |= missing
    for key, text in {"issuer": texts["issuer"], **addresses}.items():
        problem = "" if key in problems else providers.address_problem(text, insecure=insecure)
        if problem:
            problems[key] = problem
    frames = form.get("frames", "").lower().split() or [
        origin_of_url(text) for text in (texts["issuer"], addresses["authorization_url"])
    ]
    if len(frames) > MAX_FRAMES or not all(providers.is_origin(frame, insecure=insecure) for frame in frames):
        problems.setdefault("frames", FRAMES)
    deployments = list(dict.fromkeys(form.get("deployments", "").split()))
    if len(deployments) > MAX_DEPLOYMENTS or any(len(name) > ID_LENGTH for name in deployments):
        problems["deployments"] = DEPLOYMENTS
    audience = normalise_line(form.get("token_audience", ""))
    if len(audience) > ADDRESS_LENGTH:
        problems["token_audience"] = providers.NO_ADDRESS
    if problems:
        raise InvalidFields(problems)
    settings = LtiSettings(
        **addresses,
        token_audience=audience,
        deployments=tuple(deployments),
        frames=tuple(dict.fromkeys(frames)),
    )
    return texts, settings


def add_platform(
    db: Session, texts: Mapping[str, str], settings: LtiSettings, by: UUID | None, *, trusts: bool = True
) -> IdentityProvider:
    """Add a platform. Raises Conflict for one that is there, or whose issuer has other keys."""
    provider = IdentityProvider(
        protocol=Protocol.lti,
        name=texts["name"],
        issuer=texts["issuer"],
        client_id=texts["client_id"],
        settings=settings.model_dump(mode="json"),
        trusts_teachers=trusts,
    )
    return providers.add_provider(db, provider, by, anchor=ANCHOR)


def change_platform(db: Session, provider: IdentityProvider, settings: LtiSettings, name: str, by: UUID) -> None:
    """Replace the settings of a platform. Raises Conflict."""
    document = settings.model_dump(mode="json")
    providers.change_settings(db, provider, by, document, anchor=ANCHOR, name=name)


def accept_deployment(db: Session, provider: IdentityProvider, deployment: str, by: UUID) -> None:
    """Accept the launches of one more deployment. Raises InvalidFields."""
    settings, name = lti_settings(provider), normalise_line(deployment)
    if not 0 < len(name) <= ID_LENGTH or " " in name or len(settings.deployments) >= MAX_DEPLOYMENTS:
        raise InvalidFields({"deployments": DEPLOYMENTS})
    names = tuple(dict.fromkeys((*settings.deployments, name)))
    change_platform(db, provider, settings.model_copy(update={"deployments": names}), "", by)


def find_platform(db: Session, issuer: str, client_id: str) -> IdentityProvider:
    """Return the platform that begins a launch; the only one of its issuer where it names no client. Raises
    FederationRefused."""
    is_readable = issuer.isprintable() and client_id.isprintable()
    rows = repository.load_registrations(db, issuer, client_id) if is_readable else []
    found = [row for row in rows if row.protocol == Protocol.lti]
    if len(found) != 1:
        raise FederationRefused("issuer", NOT_REGISTERED)
    providers.require_active(found[0])
    return found[0]
