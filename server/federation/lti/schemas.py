"""Settings of an LTI platform."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from server.federation.models import ADDRESS_LENGTH, ID_LENGTH, IdentityProvider

Address = Annotated[str, Field(max_length=ADDRESS_LENGTH)]
Identifier = Annotated[str, Field(min_length=1, max_length=ID_LENGTH)]
MAX_DEPLOYMENTS, MAX_FRAMES = 50, 8


class LtiSettings(BaseModel):
    """A platform's addresses.

    `deployments` are those whose launches are accepted; `frames` are the origins of the pages that may show ours in a
    frame; `token_audience` is empty where it is the token's address.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    authorization_url: Address
    token_url: Address
    keys_url: Address
    token_audience: Address = ""
    deployments: Annotated[tuple[Identifier, ...], Field(max_length=MAX_DEPLOYMENTS)] = ()
    frames: Annotated[tuple[str, ...], Field(max_length=MAX_FRAMES)] = ()


def lti_settings(provider: IdentityProvider) -> LtiSettings:
    return LtiSettings.model_validate(provider.settings)
