"""Access to the services of a platform (LTI Security Framework, 4.1): a token for an assertion that we sign."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any
from urllib.parse import urlencode
from uuid import UUID, uuid4

from server.database import Database
from server.federation import signing
from server.federation.errors import OutgoingError
from server.federation.lti.schemas import lti_settings
from server.federation.models import IdentityProvider
from server.federation.outgoing import HttpAnswer, Outgoing

AGS = "https://purl.imsglobal.org/spec/lti-ags/scope/"
LINE_ITEM_SCOPE, SCORE_SCOPE = f"{AGS}lineitem", f"{AGS}score"
ROSTER_SCOPE = "https://purl.imsglobal.org/spec/lti-nrps/scope/contextmembership.readonly"
ASSERTION = "urn:ietf:params:oauth:client-assertion-type:jwt-bearer"
FORM_TYPE = "application/x-www-form-urlencoded"
MAX_TOKEN, MAX_SECONDS, MARGIN_SECONDS, MAX_CACHED = 8000, 3600, 30, 500
NO_TOKEN = "la plateforme ne donne pas d’accès à ses services"


class AccessTokenCache:
    """Thread-safe cache of access tokens, by registration and scopes."""

    def __init__(self, database: Database, outgoing: Outgoing, clock: Callable[[], float] = time.monotonic) -> None:
        self._database, self._outgoing, self._clock = database, outgoing, clock
        self._cached: dict[tuple[UUID, str], tuple[str, float]] = {}
        self._lock = threading.Lock()

    def get(self, provider: IdentityProvider, scopes: Sequence[str]) -> str:
        """Return a token that is still good. Raises OutgoingError."""
        key = (provider.id, " ".join(scopes))
        with self._lock:
            token, ends = self._cached.get(key, ("", 0.0))
        return token if token and self._clock() < ends else self.renew(provider, scopes)

    def forget(self, provider: IdentityProvider) -> None:
        """Forget the tokens of a platform, which it has refused."""
        with self._lock:
            for key in [key for key in self._cached if key[0] == provider.id]:
                del self._cached[key]

    def request(
        self,
        provider: IdentityProvider,
        scopes: Sequence[str],
        method: str,
        url: str,
        *,
        headers: Mapping[str, str] | None = None,
        **options: Any,
    ) -> HttpAnswer:
        """Ask a service of the platform with a token; one that is refused is renewed once. `options` are those of
        `Outgoing.request`. Raises OutgoingError."""

        def ask() -> HttpAnswer:
            bearer = {"Authorization": f"Bearer {self.get(provider, scopes)}"}
            return self._outgoing.request(method, url, headers={**bearer, **(headers or {})}, **options)

        try:
            return ask()
        except OutgoingError as error:
            if error.status != 401:
                raise
        self.forget(provider)
        return ask()

    def renew(self, provider: IdentityProvider, scopes: Sequence[str]) -> str:
        """Return a new token. Raises OutgoingError."""
        settings, scope = lti_settings(provider), " ".join(scopes)
        claims = {
            "iss": provider.client_id,
            "sub": provider.client_id,
            "aud": settings.token_audience or settings.token_url,
            "jti": str(uuid4()),
        }
        form = {
            "grant_type": "client_credentials",
            "client_assertion_type": ASSERTION,
            "client_assertion": signing.sign_claims(self._database, claims),
            "scope": scope,
        }
        answer = self._outgoing.request(
            "POST", settings.token_url, headers={"Content-Type": FORM_TYPE}, content=urlencode(form).encode()
        )
        token, seconds = _read_token(answer.json())
        with self._lock:
            if len(self._cached) >= MAX_CACHED:
                self._cached.clear()
            self._cached[provider.id, scope] = (token, self._clock() + seconds - MARGIN_SECONDS)
        return token


def _read_token(document: Any) -> tuple[str, float]:
    """Return the token of an answer, with its seconds. Raises OutgoingError."""
    token = document.get("access_token") if isinstance(document, dict) else None
    if not isinstance(token, str) or not 0 < len(token) <= MAX_TOKEN or not token.isascii() or not token.isprintable():
        raise OutgoingError(NO_TOKEN)
    seconds = document.get("expires_in")
    valid = isinstance(seconds, int | float) and not isinstance(seconds, bool) and seconds > 0
    return token, min(float(seconds), MAX_SECONDS) if valid else MARGIN_SECONDS
