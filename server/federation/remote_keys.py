"""The public keys of other systems (JWKS): fetched within bounds, cached, and fetched anew for an unknown key."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from server.federation.errors import OutgoingError
from server.federation.outgoing import Outgoing
from server.federation.remote_documents import RemoteDocumentCache

MAX_DOCUMENT, MAX_KEYS, MAX_CACHED = 64 * 1024, 30, 200
MIN_RSA_BITS, MAX_RSA_BITS = 2048, 8192
FRESH_SECONDS, RETRY_SECONDS = 600.0, 30.0
#: Type of a key, with the algorithms that it may verify.
ALGORITHMS_BY_TYPE: Mapping[str, frozenset[str]] = {
    "RSA": frozenset({"RS256", "PS256"}),
    "EC": frozenset({"ES256"}),
}
#: Members of a public key: private ones, and addresses of certificates, are left out.
PUBLIC_MEMBERS = frozenset({"kty", "n", "e", "crv", "x", "y"})


@dataclass(frozen=True)
class KnownKey:
    """A public key, and the algorithms for which it may be used."""

    key: Any  # joserfc's
    algorithms: frozenset[str]


class RemoteKeyCache:
    """Thread-safe cache by address. Keys that are `FRESH_SECONDS` old are fetched again; where that fails, the earlier
    ones stay for a while. An unknown key has the document fetched again, every `RETRY_SECONDS` at most."""

    def __init__(self, outgoing: Outgoing, clock: Callable[[], float] = time.monotonic) -> None:
        self._documents = RemoteDocumentCache(
            lambda url: parse_keys(outgoing.get_json(url, most=MAX_DOCUMENT)),
            clock,
            fresh_seconds=FRESH_SECONDS,
            retry_seconds=RETRY_SECONDS,
            most=MAX_CACHED,
        )

    def find(self, url: str, kid: str) -> KnownKey:
        """Return the key of this id. Raises OutgoingError where there is none, or no document."""
        keys = self._documents.find(url, lambda known: kid in known)
        if keys is None or kid not in keys:
            raise OutgoingError("aucune clé publiée n’a ce numéro", retry=True)
        return keys[kid]

    def count(self, url: str) -> int:
        """Fetch the document, and return how many keys of it can verify a signature. Raises OutgoingError for none."""
        count = len(self._documents.refresh(url))
        if not count:
            raise OutgoingError("sa liste de clés n’a aucune clé qui vérifie une signature")
        return count


def parse_keys(document: Any) -> Mapping[str, KnownKey]:
    """Return the keys of a JWKS that verify signatures, by id; others are left out. Raises OutgoingError."""
    rows = document.get("keys") if isinstance(document, dict) else None
    if not isinstance(rows, list) or len(rows) > MAX_KEYS:
        raise OutgoingError("ce n’est pas une liste de clés")
    keys = {}
    for row in rows:
        known = _parse_key(row)
        if known is not None:
            kid = str(row["kid"])
            if kid in keys:
                raise OutgoingError("deux clés ont le même numéro")
            keys[kid] = known
    return keys


def _parse_key(row: Any) -> KnownKey | None:
    """Return a public signing key with an id, of a safe size; None for anything else."""
    if not isinstance(row, dict) or not isinstance(row.get("kid"), str) or not 0 < len(row["kid"]) <= 255:
        return None
    kind = row.get("kty")
    allowed = ALGORITHMS_BY_TYPE.get(kind, frozenset()) if isinstance(kind, str) else frozenset()
    algorithms = allowed & {row["alg"]} if isinstance(row.get("alg"), str) else allowed
    if not algorithms or row.get("use", "sig") != "sig":
        return None
    key = _import_key({name: row[name] for name in PUBLIC_MEMBERS & row.keys()})
    return None if key is None else KnownKey(key, algorithms)


def _import_key(members: Mapping[str, Any]) -> Any:
    """Return the RSA key, of a safe size, or the key on P-256 with these members; None for any other."""
    from joserfc.errors import JoseError
    from joserfc.jwk import ECKey, RSAKey

    try:
        if members["kty"] == "RSA":
            if 6 * len(members["n"]) < MIN_RSA_BITS:  # joserfc would warn of it
                return None
            key = RSAKey.import_key(members)
            return key if MIN_RSA_BITS <= key.public_key.key_size <= MAX_RSA_BITS else None
        return ECKey.import_key(members) if members.get("crv") == "P-256" else None
    except (JoseError, ValueError, TypeError, KeyError):
        return None
