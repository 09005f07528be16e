"""Settings of a CAS server; its address is the issuer of the provider's row."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from server.federation.models import ADDRESS_LENGTH, IdentityProvider
from server.federation.rules import ENT_RULE, Rule

#: The client id of every CAS server: the protocol has none.
CLIENT_ID = "cas"


class CasSettings(BaseModel):
    """`service` is our own address, as the server knows it: that of a request is its sender's to choose, and a ticket
    that was made for another site would be ours."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    service: Annotated[str, Field(min_length=1, max_length=ADDRESS_LENGTH)]
    rule: Rule = ENT_RULE


def cas_settings(provider: IdentityProvider) -> CasSettings:
    return CasSettings.model_validate(provider.settings)
