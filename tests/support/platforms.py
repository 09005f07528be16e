"""A platform of a school in this process: its keys, launches, token service, gradebook and list, without sockets."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any
from urllib.parse import parse_qs, parse_qsl, urlsplit
from uuid import uuid4

import pytest

from server.base.app_services import add_services
from server.federation.lti import registration
from server.federation.lti.schemas import LtiSettings
from server.federation.models import IdentityProvider
from server.federation.outgoing import Outgoing
from server.federation.service import Federation
from tests.support.client import TestClient
from tests.support.service import Site

pytest.importorskip("joserfc", reason="the extra `federation` is not installed")

SERVICE = "https://balise.example"
CLAIM = "https://purl.imsglobal.org/spec/lti/claim/"
AGS = "https://purl.imsglobal.org/spec/lti-ags/"
NRPS = "https://purl.imsglobal.org/spec/lti-nrps/"
LINKING = "https://purl.imsglobal.org/spec/lti-dl/claim/"
LEARNER = "http://purl.imsglobal.org/vocab/lis/v2/membership#Learner"
INSTRUCTOR = "http://purl.imsglobal.org/vocab/lis/v2/membership#Instructor"
ASSISTANT = "http://purl.imsglobal.org/vocab/lis/v2/membership/Instructor#TeachingAssistant"
CLIENT, DEPLOYMENT = "balise-1", "7"
Handler = Callable[[str, str, Mapping[str, str], bytes], tuple[int, Mapping[str, str], bytes]]


@cache
def private_key() -> Any:
    from joserfc.jwk import RSAKey

    return RSAKey.generate_key(2048, {"kid": "platform-1", "use": "sig", "alg": "RS256"})


@cache
def our_private_pem() -> str:
    """The service's own key, made once in a process; `tests/federation/test_walls.py` has the service make its own."""
    from joserfc.jwk import RSAKey

    return str(RSAKey.generate_key(2048).as_pem(private=True).decode())


@dataclass
class Platform:
    """Handles the requests that the service sends it, and signs launches. `handlers` answer other paths."""

    issuer: str = "https://moodle.example"
    handlers: dict[str, Handler] = field(default_factory=dict)
    requests: list[tuple[str, str]] = field(default_factory=list)

    @property
    def settings(self) -> LtiSettings:
        return LtiSettings(
            authorization_url=f"{self.issuer}/auth.php",
            token_url=f"{self.issuer}/token.php",
            keys_url=f"{self.issuer}/certs.php",
            deployments=(DEPLOYMENT,),
            frames=(self.issuer,),
        )

    def exchange(
        self,
        method: str,
        url: str,
        headers: Mapping[str, str],
        content: bytes,
        _most: int,
        *,
        timeouts: tuple[float, float, float],
    ) -> tuple[int, Mapping[str, str], bytes]:
        assert timeouts[2] <= 12
        assert url.startswith(self.issuer), url
        path = urlsplit(url).path
        self.requests.append((method, path))
        if path == "/certs.php":
            return 200, {}, json.dumps({"keys": [private_key().as_dict(private=False)]}).encode()
        if path == "/token.php":
            return 200, {}, json.dumps({"access_token": "jeton", "expires_in": 3600}).encode()
        for prefix, handle in self.handlers.items():
            if path.startswith(prefix):
                return handle(method, url, headers, content)
        return 404, {}, b"{}"

    def federation(self, site: Site) -> Federation:
        return Federation(site.settings, Outgoing(exchange=self.exchange))

    def register(self, site: Site, **changes: Any) -> IdentityProvider:
        """Add this platform to a site, whose requests it handles from now on."""
        add_services(site.app, self.federation(site))
        texts = {"name": "Moodle du lycée", "issuer": self.issuer, "client_id": CLIENT}
        with site.database.write() as db:
            return registration.add_platform(db, texts, self.settings.model_copy(update=changes), None)

    def claims(self, nonce: str, /, **changes: Any) -> dict[str, Any]:
        """Return the claims of a good launch of a student; names of claims without their prefix are completed."""
        now = int(time.time())
        claims: dict[str, Any] = {
            "iss": self.issuer,
            "aud": CLIENT,
            "sub": "42",
            "iat": now,
            "exp": now + 600,
            "nonce": nonce,
            "name": "Ada Lovelace",
            "given_name": "Ada",
            "family_name": "Lovelace",
            f"{CLAIM}version": "1.3.0",
            f"{CLAIM}message_type": "LtiResourceLinkRequest",
            f"{CLAIM}deployment_id": DEPLOYMENT,
            f"{CLAIM}target_link_uri": f"{SERVICE}/l20/exercices/poses",
            f"{CLAIM}roles": [LEARNER],
            f"{CLAIM}context": {"id": "c1", "title": "Robotique"},
            f"{CLAIM}resource_link": {"id": "r1"},
            f"{AGS}claim/endpoint": {
                "scope": [f"{AGS}scope/lineitem", f"{AGS}scope/score"],
                "lineitems": f"{self.issuer}/items?type_id=3",
            },
            f"{NRPS}claim/namesroleservice": {
                "context_memberships_url": f"{self.issuer}/members",
                "service_versions": ["2.0"],
            },
        }
        for name, value in changes.items():
            key = f"{CLAIM}{name}" if f"{CLAIM}{name}" in claims else name
            claims[key] = value
        return {name: value for name, value in claims.items() if value is not None}


def sign(claims: Mapping[str, Any], header: Mapping[str, Any] | None = None, key: Any = None) -> str:
    from joserfc import jwt

    given = {"alg": "RS256", "kid": "platform-1", "typ": "JWT", **(header or {})}
    return jwt.encode(given, dict(claims), key or private_key(), algorithms=[given["alg"]])


class Browser(TestClient):
    """A browser on https, which the service knows by `balise.example`."""

    def __init__(self, site: Site) -> None:
        super().__init__(site.app, base_url=SERVICE, follow_redirects=False, raise_server_exceptions=False)

    def begin(self, platform: Platform, *, method: str = "GET", **changes: str) -> dict[str, str]:
        """Begin a launch, and return the parameters with which the platform is asked for its token."""
        hints = {"iss": platform.issuer, "client_id": CLIENT, "login_hint": "u42", "lti_message_hint": "m1"}
        given = {**hints, "target_link_uri": f"{SERVICE}/l20/exercices/poses", **changes}
        options = {"params": given} if method == "GET" else {"data": given}
        first = self.request(method, "/lti/connexion", **options)  # type: ignore[arg-type]
        assert first.status_code == 303, first.text
        second = self.get(first.headers["location"])
        assert second.status_code == 303, second.text
        asked = urlsplit(second.headers["location"])
        assert f"{asked.scheme}://{asked.netloc}{asked.path}" == platform.settings.authorization_url
        return dict(parse_qsl(asked.query))

    def launch(self, platform: Platform, *, headers: Mapping[str, str] | None = None, **changes: Any) -> Any:
        """Go through a whole launch, and return the answer to its token."""
        asked = self.begin(platform)
        token = sign(platform.claims(asked["nonce"], **changes))
        return self.arrive(asked["state"], token, headers)

    def arrive(self, state: str, token: str, headers: Mapping[str, str] | None = None) -> Any:
        cross_site = {"Origin": "https://moodle.example", "Sec-Fetch-Site": "cross-site", **(headers or {})}
        return self.post("/lti/lancement", data={"state": state, "id_token": token}, headers=cross_site)


def query_of(location: str) -> dict[str, str]:
    return {name: values[0] for name, values in parse_qs(urlsplit(location).query).items()}


def new_subject() -> str:
    return uuid4().hex
