"""Settings of an OpenID Connect server; its issuer and our client id stand in the provider's row."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from server.federation.models import ADDRESS_LENGTH, IdentityProvider
from server.federation.rules import OIDC_RULE, Rule

MAX_SECRET, MAX_SCOPES = 500, 20
Address = Annotated[str, Field(min_length=1, max_length=ADDRESS_LENGTH)]
Scope = Annotated[str, Field(pattern=r"^[\x21\x23-\x5b\x5d-\x7e]{1,100}$")]  # RFC 6749, 3.3


class OidcSettings(BaseModel):
    """`service` is our own address, as the server knows it: that of a request is its sender's to choose.

    `client_secret` is empty where we prove ourselves by our own key, or are a public client.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    service: Address
    client_secret: Annotated[str, Field(max_length=MAX_SECRET)] = ""
    scopes: Annotated[tuple[Scope, ...], Field(max_length=MAX_SCOPES)] = ("openid", "profile")
    rule: Rule = OIDC_RULE


def oidc_settings(provider: IdentityProvider) -> OidcSettings:
    return OidcSettings.model_validate(provider.settings)
