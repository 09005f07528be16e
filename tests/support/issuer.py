"""An OpenID Connect server and a CAS server in memory, which answer in place of `Outgoing`."""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import threading
import time
from collections.abc import Mapping
from functools import cache
from typing import Any
from urllib.parse import parse_qs, urlsplit

from cryptography.hazmat.primitives.asymmetric.padding import PKCS1v15
from cryptography.hazmat.primitives.hashes import SHA256
from joserfc import jws
from joserfc.jwk import ECKey, RSAKey

from server.federation.errors import OutgoingError
from server.federation.outgoing import HttpAnswer

ISSUER, CLIENT = "https://sso.univ.example/realm", "balise"
KEYS_URL = f"{ISSUER}/keys"


@cache
def signing_key(kid: str = "k1") -> RSAKey:
    return RSAKey.generate_key(2048, {"kid": kid})


@cache
def curve_key() -> ECKey:
    return ECKey.generate_key("P-256", {"kid": "ec"})


def left_half(access_token: str) -> str:
    return _encode(hashlib.sha256(access_token.encode()).digest()[:16])


class FakeIssuer:
    """Answers as a server of `ISSUER`; `person` are the claims of who signs in, `codes` its codes with nonces."""

    insecure = False

    def __init__(self) -> None:
        self.person: dict[str, Any] = {"sub": "u1", "name": "Ada Lovelace"}
        self.codes: dict[str, str] = {}
        self.userinfo: dict[str, Any] | None = None
        self.metadata: dict[str, Any] = {
            "issuer": ISSUER,
            "authorization_endpoint": f"{ISSUER}/auth",
            "token_endpoint": f"{ISSUER}/token",
            "jwks_uri": KEYS_URL,
            "code_challenge_methods_supported": ["S256"],
            "authorization_response_iss_parameter_supported": True,
        }
        self.requests: list[tuple[str, str, Mapping[str, str], bytes]] = []
        self.token_changes: dict[str, Any] = {}
        self._lock = threading.Lock()

    def claims(self, nonce: str = "n", **changes: Any) -> dict[str, Any]:
        """Return the claims of a good token; a change to None removes one."""
        now = int(time.time())
        times = {"iat": now, "exp": now + 300, "nbf": now}
        good = {
            "iss": ISSUER,
            "aud": CLIENT,
            "azp": CLIENT,
            "nonce": nonce,
            "at_hash": left_half("access"),
            "sid": "s1",
        }
        merged = {**self.person, **good, **times, **changes}
        return {name: value for name, value in merged.items() if value is not None}

    def sign(self, claims: Any, **header: Any) -> str:
        return sign(claims, **header)

    def logout_token(self, **changes: Any) -> str:
        now = int(time.time())
        events = {"http://schemas.openid.net/event/backchannel-logout": {}}
        good = {"iss": ISSUER, "aud": CLIENT, "iat": now, "exp": now + 120, "jti": "j", "events": events, "sid": "s1"}
        merged = {**good, **changes}
        return sign({name: value for name, value in merged.items() if value is not None}, typ="logout+jwt")

    def new_code(self, nonce: str) -> str:
        code = f"code{len(self.codes)}"
        self.codes[code] = nonce
        return code

    def request(
        self,
        method: str,
        url: str,
        *,
        headers: Mapping[str, str] | None = None,
        content: bytes = b"",
        most: int = 0,
        accept: str = "",
    ) -> HttpAnswer:
        self.requests.append((method, url, headers or {}, content))
        return HttpAnswer(200, {}, json.dumps(self._answer(url, content)).encode())

    def get_json(self, url: str, *, headers: Mapping[str, str] | None = None, most: int = 0) -> Any:
        return self.request("GET", url, headers=headers).json()

    def _answer(self, url: str, content: bytes) -> Any:
        if url.endswith("/.well-known/openid-configuration"):
            return self.metadata
        if url == KEYS_URL:
            keys = (signing_key(), curve_key())
            return {"keys": [{**key.as_dict(private=False), "use": "sig"} for key in keys]}
        if url == f"{ISSUER}/token":
            with self._lock:
                nonce = self.codes.pop(parse_qs(content.decode())["code"][0], None)
            if nonce is None:
                raise OutgoingError("réponse 400", status=400)
            return {"access_token": "access", "id_token": sign(self.claims(**{"nonce": nonce, **self.token_changes}))}
        if url == f"{ISSUER}/userinfo":
            return self.userinfo
        raise OutgoingError("réponse 404", status=404)


def sign(claims: Any, *, key: Any = None, **header: Any) -> str:
    """Sign any claims with any header: by RS256 unless told otherwise; HS256 takes the public key for its secret."""
    whole = {"alg": "RS256", "kid": "k1", **header}
    whole = {name: value for name, value in whole.items() if value is not None}
    body = claims if isinstance(claims, bytes) else json.dumps(claims).encode()
    if whole["alg"] in {"PS256", "ES256", "RS512"}:
        return jws.serialize_compact(whole, body, key or signing_key(), algorithms=[whole["alg"]])
    parts = f"{_encode(json.dumps(whole).encode())}.{_encode(body)}"
    if whole["alg"] == "RS256":
        private = (key or signing_key()).private_key
        return f"{parts}.{_encode(private.sign(parts.encode(), PKCS1v15(), SHA256()))}"
    secret = signing_key().as_pem(private=False)
    signature = hmac.digest(secret, parts.encode(), "sha256") if whole["alg"] == "HS256" else b""
    return f"{parts}.{_encode(signature)}"


def _encode(part: bytes) -> str:
    return base64.urlsafe_b64encode(part).rstrip(b"=").decode()


class FakeCas:
    """Answers `/p3/serviceValidate` at any address: each ticket once, for the service that it was made for."""

    insecure = False

    def __init__(self) -> None:
        self.tickets: dict[str, str] = {}
        self.user, self.attributes = "u1", {"ENTPersonNom": "Lovelace", "ENTPersonPrenom": "Ada"}
        self.requests: list[str] = []
        self._lock = threading.Lock()

    def new_ticket(self, service: str) -> str:
        ticket = f"ST-{len(self.tickets)}-abcdef"
        self.tickets[ticket] = service
        return ticket

    def request(self, method: str, url: str, *, most: int = 0, accept: str = "") -> HttpAnswer:
        self.requests.append(url)
        query = {name: values[0] for name, values in parse_qs(urlsplit(url).query).items()}
        with self._lock:
            service = self.tickets.get(query["ticket"])
            if service == query["service"]:
                self.tickets[query["ticket"]] = "used"
        outcome = '<cas:authenticationFailure code="INVALID_TICKET"/>'
        if service == query["service"]:
            rows = "".join(f"<cas:{name}>{value}</cas:{name}>" for name, value in self.attributes.items())
            outcome = f"<cas:user>{self.user}</cas:user><cas:attributes>{rows}</cas:attributes>"
            outcome = f"<cas:authenticationSuccess>{outcome}</cas:authenticationSuccess>"
        document = f'<cas:serviceResponse xmlns:cas="http://www.yale.edu/tp/cas">{outcome}</cas:serviceResponse>'
        return HttpAnswer(200, {}, document.encode())
