"""The sign-in of LTI 1.3: a browser begins, keeps a cookie, and comes back with a token (OIDC third-party login).

Functions work inside the caller's transaction, but for `read_launch`, which may ask the platform for its keys.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import urlencode

from sqlalchemy.orm import Session

from server.base.http import LTI_LAUNCH_PATH
from server.federation import pending, providers, repository
from server.federation.errors import FederationRefused
from server.federation.lti import registration
from server.federation.lti.launch import Launch, target_path, verify_launch
from server.federation.lti.schemas import LtiSettings, lti_settings
from server.federation.models import IdentityProvider, PendingSignIn
from server.federation.outgoing import with_query
from server.federation.remote_keys import RemoteKeyCache

OTHER_DEPLOYMENT = "Ce lancement est d’un autre déploiement que celui qui l’a commencé : recommencez depuis le cours."
HINTS = ("login_hint", "lti_message_hint", "lti_deployment_id")


@dataclass(frozen=True)
class LaunchInitiation:
    """The parameters by which a platform begins a launch (LTI Core 1.3, 5.1.1)."""

    iss: str = ""
    login_hint: str = ""
    target_link_uri: str = ""
    client_id: str = ""
    lti_message_hint: str = ""
    lti_deployment_id: str = ""

    def query(self) -> str:
        """Return the query by which the same launch begins once more."""
        return urlencode({name: value for name, value in vars(self).items() if value})


@dataclass(frozen=True)
class BegunLaunch:
    """A launch that begins; `frames` are the origins that may show its pages."""

    begun: pending.BegunSignIn
    frames: str


def begin_launch(db: Session, initiation: LaunchInitiation, service: str) -> BegunLaunch:
    """Begin a launch; `service` is our own address. Raises FederationRefused."""
    provider = registration.find_platform(db, initiation.iss, initiation.client_id)
    if not initiation.login_hint:
        raise FederationRefused("claims", "La plateforme ne dit pas de qui il s’agit (login_hint).")
    details = {name: getattr(initiation, name) for name in HINTS}
    begun = pending.begin_sign_in(db, provider.id, target_path(initiation.target_link_uri, service), details)
    return BegunLaunch(begun, format_frame_origins(lti_settings(provider)))


def format_frame_origins(settings: LtiSettings) -> str:
    return " ".join(settings.frames)


def find_begun_launch(db: Session, state: str) -> tuple[PendingSignIn, IdentityProvider]:
    """Return a launch that has begun, with its platform. Raises FederationRefused."""
    begun = pending.find_pending_sign_in(db, state)
    provider = repository.find_provider(db, begun.provider_id)
    if provider is None:
        raise FederationRefused("state", pending.USED)
    return begun, provider


def authorization_url(db: Session, begun: PendingSignIn, provider: IdentityProvider, state: str, service: str) -> str:
    """Return the address of the platform to which the browser goes for its token (OIDC, implicit flow by form)."""
    query = {
        "scope": "openid",
        "response_type": "id_token",
        "response_mode": "form_post",
        "prompt": "none",
        "client_id": provider.client_id,
        "redirect_uri": service + LTI_LAUNCH_PATH,
        "login_hint": str(begun.details.get("login_hint", "")),
        "state": state,
        "nonce": pending.replace_nonce(db, begun, begun.details),
    }
    if begun.details.get("lti_message_hint"):
        query["lti_message_hint"] = str(begun.details["lti_message_hint"])
    return with_query(lti_settings(provider).authorization_url, query)


def read_launch(
    begun: PendingSignIn, provider: IdentityProvider, token: str, keys: RemoteKeyCache, service: str
) -> Launch:
    """Return the launch of a token, verified but for its nonce. Raises FederationRefused."""
    providers.require_active(provider)
    launch = verify_launch(provider, lti_settings(provider), token, keys, service)
    announced = begun.details.get("lti_deployment_id")
    if announced and announced != launch.deployment:
        raise FederationRefused("deployment", OTHER_DEPLOYMENT)
    return launch


def restart_query(details: Mapping[str, object], provider: IdentityProvider, target: str) -> str:
    """Return the query by which a begun launch begins once more, in another tab."""
    hints = {name: str(details.get(name) or "") for name in HINTS}
    return LaunchInitiation(iss=provider.issuer, client_id=provider.client_id, target_link_uri=target, **hints).query()
