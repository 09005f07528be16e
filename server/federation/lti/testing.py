"""The test of a platform that its administrator asks for: its keys, and a token for its services."""

from __future__ import annotations

from server.database import Database
from server.federation.lti.access_tokens import SCORE_SCOPE, AccessTokenCache
from server.federation.lti.schemas import lti_settings
from server.federation.models import IdentityProvider
from server.federation.service import Federation


def check_platform(database: Database, federation: Federation, provider: IdentityProvider, _service: str) -> str:
    """Return a sentence about a platform that works. Raises OutgoingError."""
    settings = lti_settings(provider)
    keys = federation.keys.count(settings.keys_url)
    AccessTokenCache(database, federation.outgoing).renew(provider, [SCORE_SCOPE])
    many = "s" if keys > 1 else ""
    return f"La plateforme publie {keys} clé{many}, et nous donne accès à l’envoi des notes."
