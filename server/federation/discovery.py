"""The document by which an OpenID Connect server tells its addresses (Discovery 1.0), bounded and cached."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from server.federation.errors import OutgoingError
from server.federation.models import ADDRESS_LENGTH
from server.federation.outgoing import Outgoing, check_url
from server.federation.remote_documents import RemoteDocumentCache

WELL_KNOWN = "/.well-known/openid-configuration"
MAX_DOCUMENT, MAX_CACHED, MAX_LISTED = 64 * 1024, 100, 100
FRESH_SECONDS, RETRY_SECONDS = 3600.0, 10.0

Address = Annotated[str, Field(min_length=1, max_length=ADDRESS_LENGTH)]
Listed = Annotated[tuple[Annotated[str, Field(max_length=100)], ...], Field(max_length=MAX_LISTED)]


class Metadata(BaseModel):
    """The members of a discovery document that are read. `answers_with_issuer` stands for RFC 9207."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    issuer: Address
    authorization_endpoint: Address
    token_endpoint: Address
    jwks_uri: Address
    userinfo_endpoint: Annotated[str, Field(max_length=ADDRESS_LENGTH)] = ""
    end_session_endpoint: Annotated[str, Field(max_length=ADDRESS_LENGTH)] = ""
    token_endpoint_auth_methods_supported: Listed = ("client_secret_basic",)
    code_challenge_methods_supported: Listed = ()
    answers_with_issuer: bool = Field(default=False, alias="authorization_response_iss_parameter_supported")


def parse_metadata(document: Any, issuer: str, *, insecure: bool = False) -> Metadata:
    """Return what a document says, where it is of this issuer and has https addresses alone. Raises OutgoingError."""
    if not isinstance(document, dict):
        raise OutgoingError("ce n’est pas la description d’un serveur OpenID Connect")
    try:
        read = Metadata.model_validate({name: value for name, value in document.items() if value is not None})
    except ValidationError as error:
        where = str(error.errors()[0]["loc"][0])
        raise OutgoingError(f"dans la description du serveur, « {where} » manque ou n’est pas lisible") from None
    if read.issuer != issuer:
        raise OutgoingError("la description est celle d’un autre serveur (« issuer » diffère)")
    own = (read.authorization_endpoint, read.token_endpoint, read.jwks_uri)
    for url in (*own, *filter(None, (read.userinfo_endpoint, read.end_session_endpoint))):
        try:
            check_url(url, insecure=insecure)
        except ValueError:
            raise OutgoingError("dans la description du serveur, une adresse n’est pas en https") from None
    if read.code_challenge_methods_supported and "S256" not in read.code_challenge_methods_supported:
        raise OutgoingError("le serveur ne connaît pas PKCE avec S256")
    return read


class Discovery:
    """Thread-safe cache by issuer. A document that is `FRESH_SECONDS` old is fetched again; where that fails, the
    earlier one stays. A server that does not answer is asked every `RETRY_SECONDS` at most."""

    def __init__(self, outgoing: Outgoing, clock: Callable[[], float] = time.monotonic) -> None:
        self._outgoing = outgoing
        self._documents = RemoteDocumentCache(
            self._fetch, clock, fresh_seconds=FRESH_SECONDS, retry_seconds=RETRY_SECONDS, most=MAX_CACHED
        )

    def find(self, issuer: str) -> Metadata:
        """Return the description of a server. Raises OutgoingError."""
        metadata = self._documents.find(issuer)
        if metadata is None:
            raise OutgoingError("le serveur n’a pas répondu à l’instant", retry=True)
        return metadata

    def refresh(self, issuer: str) -> Metadata:
        """Fetch the document. Raises OutgoingError."""
        return self._documents.refresh(issuer)

    def _fetch(self, issuer: str) -> Metadata:
        document = self._outgoing.get_json(issuer.rstrip("/") + WELL_KNOWN, most=MAX_DOCUMENT)
        return parse_metadata(document, issuer, insecure=self._outgoing.insecure)


def preferred_authentication(metadata: Metadata, has_secret: bool) -> str:
    """Return how a client proves itself at the token endpoint: by its secret, or by our own key, or not at all."""
    known: Sequence[str] = metadata.token_endpoint_auth_methods_supported
    if has_secret:
        posts = "client_secret_basic" not in known and "client_secret_post" in known
        return "client_secret_post" if posts else "client_secret_basic"
    return "private_key_jwt" if "private_key_jwt" in known else "none"
