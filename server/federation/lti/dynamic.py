"""Dynamic registration (LTI 1.3): a platform that was given a one-time address registers itself, and Balise with it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import timedelta
from typing import Annotated, Any
from urllib.parse import urlsplit
from uuid import UUID

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from sqlalchemy.orm import Session

from server.audit import service as audit
from server.audit.models import AuditAction
from server.base.http import LTI_BEGIN_PATH, LTI_LAUNCH_PATH
from server.database import utc_now
from server.federation import repository
from server.federation.errors import FederationRefused, OutgoingError
from server.federation.lti import registration
from server.federation.lti.access_tokens import LINE_ITEM_SCOPE, ROSTER_SCOPE, SCORE_SCOPE
from server.federation.lti.schemas import LtiSettings
from server.federation.models import ADDRESS_LENGTH, ID_LENGTH, NAME_LENGTH, IdentityProvider, RegistrationLink
from server.federation.outgoing import Outgoing, is_url, origin_of_url
from server.federation.providers import is_origin
from server.identity.models import ISSUER_LENGTH, Account
from server.identity.secrets import draw_secret_token, sha256_hex

LINK_LIFETIME = timedelta(hours=24)
TOOL = "https://purl.imsglobal.org/spec/lti-tool-configuration"
USED_LINK = "Cette adresse d’inscription a déjà servi, ou n’est plus valable : faites-en une autre."
UNREADABLE = "la plateforme ne dit pas comme il faut comment s’inscrire"
OTHER_SITE = "la plateforme nomme d’autres sites que le sien"
Url = Annotated[str, Field(min_length=1, max_length=ADDRESS_LENGTH)]


class PlatformConfiguration(BaseModel):
    """What is read of a platform's OpenID configuration."""

    model_config = ConfigDict(strict=True, frozen=True, extra="ignore")

    issuer: Annotated[str, Field(min_length=1, max_length=ISSUER_LENGTH)]
    authorization_endpoint: Url
    token_endpoint: Url
    jwks_uri: Url
    registration_endpoint: Url

    @property
    def name(self) -> str:
        return (urlsplit(self.issuer).hostname or self.issuer)[:NAME_LENGTH]


class ToolRegistration(BaseModel):
    """What is read of the answer to our registration."""

    model_config = ConfigDict(strict=True, frozen=True, extra="ignore")

    client_id: Annotated[str, Field(min_length=1, max_length=ID_LENGTH, pattern=r"^[\x20-\x7e]+$")]
    tool: dict[str, Any] = Field(alias="https://purl.imsglobal.org/spec/lti-tool-configuration", default={})

    @property
    def deployments(self) -> tuple[str, ...]:
        name = self.tool.get("deployment_id")
        is_name = isinstance(name, str | int) and 0 < len(str(name)) <= ID_LENGTH and str(name).isprintable()
        return (str(name),) if is_name else ()


def create_registration_link(db: Session, by: Account) -> str:
    """Return the token of a one-time address at which a platform registers itself."""
    token = draw_secret_token()
    db.add(RegistrationLink(token_digest=sha256_hex(token), created_by=by.id, expires_at=utc_now() + LINK_LIFETIME))
    audit.record_event(db, None, by.id, AuditAction.platform_link_made)
    return token


def require_registration_link(db: Session, token: str) -> None:
    """Raise FederationRefused for a link that has been used, or has ended."""
    if repository.find_registration_link(db, sha256_hex(token), utc_now()) is None:
        raise FederationRefused("registration link", USED_LINK)


def consume_registration_link(db: Session, token: str) -> UUID:
    """Use a link up, and return who made it: of several uses at once one succeeds. Raises FederationRefused."""
    maker = repository.consume_registration_link(db, sha256_hex(token), utc_now())
    if maker is None:
        raise FederationRefused("registration link", USED_LINK)
    return maker


def read_configuration(outgoing: Outgoing, address: str) -> PlatformConfiguration:
    """Fetch a platform's configuration, whose issuer and registration are on the same host. Raises OutgoingError."""
    try:
        found = PlatformConfiguration.model_validate(outgoing.get_json(address))
    except ValidationError as error:
        raise OutgoingError(UNREADABLE) from error
    addresses = (
        found.issuer,
        found.authorization_endpoint,
        found.token_endpoint,
        found.jwks_uri,
        found.registration_endpoint,
    )
    insecure = outgoing.insecure
    if not all(
        is_url(url, insecure=insecure) and is_origin(origin_of_url(url), insecure=insecure) for url in addresses
    ):
        raise OutgoingError(UNREADABLE)
    if {origin_of_url(found.issuer), origin_of_url(found.registration_endpoint)} != {origin_of_url(address)}:
        raise OutgoingError(OTHER_SITE)
    return found


def tool_document(service: str, keys_url: str) -> Mapping[str, Any]:
    """Return our registration, as Moodle among others wants it: lists where lists are meant, names among the claims."""
    launch = service + LTI_LAUNCH_PATH
    return {
        "application_type": "web",
        "response_types": ["id_token"],
        "grant_types": ["implicit", "client_credentials"],
        "initiate_login_uri": service + LTI_BEGIN_PATH,
        "redirect_uris": [launch],
        "client_name": "Balise",
        "jwks_uri": keys_url,
        "token_endpoint_auth_method": "private_key_jwt",
        "scope": " ".join((LINE_ITEM_SCOPE, SCORE_SCOPE, ROSTER_SCOPE)),
        TOOL: {
            "domain": urlsplit(service).netloc,
            "description": "Exercices corrigés sur-le-champ",
            "target_link_uri": launch,
            "claims": ["iss", "sub", "name", "given_name", "family_name"],
            "messages": [
                {"type": "LtiResourceLinkRequest", "target_link_uri": launch, "label": "Balise"},
                {"type": "LtiDeepLinkingRequest", "target_link_uri": launch, "label": "Choisir dans Balise"},
            ],
        },
    }


def register_tool(
    outgoing: Outgoing, configuration: PlatformConfiguration, token: str, service: str, keys_url: str
) -> ToolRegistration:
    """Register Balise in a platform, with the token that it gave for it. Raises OutgoingError."""
    headers = {"Content-Type": "application/json"}
    if token:
        headers["Authorization"] = f"Bearer {token}"
    content = json.dumps(tool_document(service, keys_url)).encode()
    answer = outgoing.request("POST", configuration.registration_endpoint, headers=headers, content=content)
    try:
        return ToolRegistration.model_validate(answer.json())
    except ValidationError as error:
        raise OutgoingError(UNREADABLE) from error


def add_registered_platform(
    db: Session, configuration: PlatformConfiguration, tool: ToolRegistration, by: UUID
) -> IdentityProvider:
    """Add the platform that has registered itself. Raises Conflict."""
    origins = (origin_of_url(configuration.issuer), origin_of_url(configuration.authorization_endpoint))
    settings = LtiSettings(
        authorization_url=configuration.authorization_endpoint,
        token_url=configuration.token_endpoint,
        keys_url=configuration.jwks_uri,
        deployments=tool.deployments,
        frames=tuple(dict.fromkeys(origins)),
    )
    texts = {"name": configuration.name, "issuer": configuration.issuer, "client_id": tool.client_id}
    return registration.add_platform(db, texts, settings, by)
