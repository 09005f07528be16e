"""The launch of LTI 1.3: a signed message of a platform becomes a person with a role in a course (LTI Core 1.3, 5.3).

Every claim that is read has its type; only roles of the course count. Of the addresses in a launch only those on the
hosts of the platform's registration are kept.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Literal
from urllib.parse import urlsplit

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from server.base.http import local_path
from server.federation.errors import FederationRefused
from server.federation.lti.schemas import LtiSettings
from server.federation.models import IdentityProvider
from server.federation.outgoing import has_origin_in, origin_of_url
from server.federation.remote_keys import RemoteKeyCache
from server.federation.schemas import ArrivedContext, CourseRole, SignedPerson
from server.federation.tokens import require_audience, verify_token

MEMBERSHIP = "http://purl.imsglobal.org/vocab/lis/v2/membership"
TEACHERS = frozenset({f"{MEMBERSHIP}#Instructor", "Instructor"})
ASSISTANTS = frozenset({f"{MEMBERSHIP}/Instructor#TeachingAssistant", f"{MEMBERSHIP}#TeachingAssistant"})
STUDENTS = frozenset({f"{MEMBERSHIP}#Learner", "Learner"})
STUDENT_KINDS = f"{MEMBERSHIP}/Learner#"
SYSTEM = "http://purl.imsglobal.org/vocab/lis/v2/system/"
NO_COURSE_ROLE = (
    "La plateforme ne vous donne de rôle que dans son administration, et aucun dans ce cours : entrez comme enseignant "
    "ou comme élève du cours."
)
ALGORITHMS = ("RS256",)
#: Pages to which no launch leads.
NO_TARGETS = ("/lti/", "/api/", "/compte", "/connexion", "/deconnexion", "/administration")
UNREADABLE = "Le lancement de la plateforme n’est pas complet : {why}."

Text = Annotated[str, BeforeValidator(lambda text: "" if text is None else text), Field(max_length=2000)]
Short = Annotated[str, Field(min_length=1, max_length=255, pattern=r"^[^\x00-\x1f\x7f]+$")]


class _Claim(BaseModel):
    model_config = ConfigDict(strict=True, frozen=True, extra="ignore", populate_by_name=False)


class ContextClaim(_Claim):
    id: Short
    title: Text = ""
    label: Text = ""


class ResourceLinkClaim(_Claim):
    id: Short
    title: Text = ""


class EndpointClaim(_Claim):
    scope: list[Text] = []
    lineitems: Text = ""
    lineitem: Text = ""


class RosterClaim(_Claim):
    context_memberships_url: Text
    service_versions: list[Text] = []


class PresentationClaim(_Claim):
    document_target: Text = ""


class LinkingClaim(_Claim):
    deep_link_return_url: Text
    accept_types: list[Text]
    accept_presentation_document_targets: list[Text] = []
    accept_multiple: bool = False
    accept_lineitem: bool = False
    data: Annotated[str, Field(max_length=8000)] = ""


class LaunchClaims(_Claim):
    """The claims that are read, with their types."""

    sub: Annotated[str, Field(min_length=1, max_length=255, pattern=r"^[\x21-\x7e]+$")]
    nonce: Short
    name: Text = ""
    given_name: Text = ""
    family_name: Text = ""
    version: Literal["1.3.0"] = Field(alias="https://purl.imsglobal.org/spec/lti/claim/version")
    message_type: Literal["LtiResourceLinkRequest", "LtiDeepLinkingRequest"] = Field(
        alias="https://purl.imsglobal.org/spec/lti/claim/message_type"
    )
    deployment: Short = Field(alias="https://purl.imsglobal.org/spec/lti/claim/deployment_id")
    roles: Annotated[list[Text], Field(max_length=100)] = Field(alias="https://purl.imsglobal.org/spec/lti/claim/roles")
    target: Text = Field(alias="https://purl.imsglobal.org/spec/lti/claim/target_link_uri", default="")
    context: ContextClaim | None = Field(alias="https://purl.imsglobal.org/spec/lti/claim/context", default=None)
    resource_link: ResourceLinkClaim | None = Field(
        alias="https://purl.imsglobal.org/spec/lti/claim/resource_link", default=None
    )
    endpoint: EndpointClaim | None = Field(alias="https://purl.imsglobal.org/spec/lti-ags/claim/endpoint", default=None)
    roster: RosterClaim | None = Field(
        alias="https://purl.imsglobal.org/spec/lti-nrps/claim/namesroleservice", default=None
    )
    presentation: PresentationClaim | None = Field(
        alias="https://purl.imsglobal.org/spec/lti/claim/launch_presentation", default=None
    )
    linking: LinkingClaim | None = Field(
        alias="https://purl.imsglobal.org/spec/lti-dl/claim/deep_linking_settings", default=None
    )


@dataclass(frozen=True)
class Launch:
    """A verified launch. `target` is a path of ours, or empty; `linking` is there where a teacher chooses content.

    `is_framed`: the platform says that it shows us in a frame.
    """

    person: SignedPerson
    nonce: str
    deployment: str
    target: str
    is_framed: bool = False
    linking: LinkingClaim | None = field(default=None)


def verify_launch(
    provider: IdentityProvider,
    settings: LtiSettings,
    token: str,
    keys: RemoteKeyCache,
    service: str,
    clock: Callable[[], float] = time.time,
) -> Launch:
    """Return the launch of a platform's token; `service` is our own address. Raises FederationRefused."""
    claims = verify_token(token, keys, settings.keys_url, algorithms=ALGORITHMS, clock=clock)
    if claims.get("iss") != provider.issuer:
        raise FederationRefused("issuer", "Ce lancement vient d’une autre plateforme.")
    require_audience(claims, provider.client_id)
    try:
        read = LaunchClaims.model_validate(dict(claims))
    except ValidationError as error:
        where = ".".join(str(part).rpartition("/")[2] for part in error.errors()[0]["loc"])
        raise FederationRefused(
            "claims", UNREADABLE.format(why=f"« {where} » manque, ou n’est pas comme il faut")
        ) from error
    if read.deployment not in settings.deployments:
        raise FederationRefused(
            "deployment", f"Le déploiement « {read.deployment[:60]} » de cette plateforme n’est pas accepté ici."
        )
    return _build_launch(provider, settings, read, service)


def _build_launch(provider: IdentityProvider, settings: LtiSettings, read: LaunchClaims, service: str) -> Launch:
    role, linking = course_role(read.roles), None
    if read.message_type == "LtiDeepLinkingRequest":
        if read.linking is None or "ltiResourceLink" not in read.linking.accept_types:
            raise FederationRefused("claims", UNREADABLE.format(why="le choix d’un contenu n’y est pas"))
        if not is_platform_url(read.linking.deep_link_return_url, provider, settings):
            raise FederationRefused("address", UNREADABLE.format(why="l’adresse de retour est sur un autre site"))
        if role is not CourseRole.teacher:
            raise FederationRefused("role", "Seul un enseignant du cours y ajoute un contenu.")
        linking = read.linking
    elif read.resource_link is None:
        raise FederationRefused("claims", UNREADABLE.format(why="« resource_link » manque"))
    person = SignedPerson(
        read.sub,
        read.name,
        read.given_name,
        read.family_name,
        role,
        contexts=() if read.context is None else (_read_arrived_context(read.context, read, provider, settings),),
    )
    is_framed = read.presentation is not None and read.presentation.document_target == "iframe"
    target = target_path(read.target, service) if read.target else ""
    return Launch(person, read.nonce, read.deployment, target, is_framed, linking)


def _read_arrived_context(
    context: ContextClaim, read: LaunchClaims, provider: IdentityProvider, settings: LtiSettings
) -> ArrivedContext:
    """Return the course, with the addresses of its services that are on the platform's hosts."""
    roster = "" if read.roster is None else read.roster.context_memberships_url
    endpoint = read.endpoint or EndpointClaim()

    def own(url: str) -> str:
        return url if is_platform_url(url, provider, settings) else ""

    return ArrivedContext(
        context.id,
        read.deployment,
        context.title or context.label,
        own(roster),
        own(endpoint.lineitems),
        own(endpoint.lineitem),
        tuple(endpoint.scope),
    )


def platform_origins(provider: IdentityProvider, settings: LtiSettings) -> Sequence[str]:
    """Return the origins on which a platform's services may be."""
    urls = (provider.issuer, settings.authorization_url, settings.token_url, settings.keys_url)
    return list(dict.fromkeys([*map(origin_of_url, urls), *settings.frames]))


def is_platform_url(url: str, provider: IdentityProvider, settings: LtiSettings) -> bool:
    return bool(url) and has_origin_in(url, platform_origins(provider, settings))


def course_role(roles: Sequence[str]) -> CourseRole:
    """Return the role in the course: of several, the one with the fewest rights.

    Roles of an institution give none. Raises FederationRefused where there are roles of the platform's system alone.
    """
    names = frozenset(roles)
    if any(name in STUDENTS or name.startswith(STUDENT_KINDS) for name in names):
        return CourseRole.student
    if names & ASSISTANTS:
        return CourseRole.assistant
    if names & TEACHERS:
        return CourseRole.teacher
    if names and all(name.startswith(SYSTEM) for name in names):
        raise FederationRefused("role", NO_COURSE_ROLE)
    return CourseRole.none


def target_path(target: str, service: str) -> str:
    """Return our path to which a launch leads; `/` for the launch's own address, and for none. Raises
    FederationRefused."""
    if not target:
        return "/"
    if origin_of_url(target) != origin_of_url(service):
        raise FederationRefused("target", UNREADABLE.format(why="la page demandée est sur un autre site"))
    base, parts = urlsplit(service).path.rstrip("/"), urlsplit(target)
    if base and not parts.path.startswith(f"{base}/"):
        return "/"
    path = local_path(parts.path.removeprefix(base) + (f"?{parts.query}" if parts.query else ""))
    return "/" if path.startswith(NO_TARGETS) else path
