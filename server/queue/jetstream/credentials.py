"""How one enters: addresses, token, nkey, TLS."""

import ssl
from pathlib import Path
from typing import Any

from nats.aio.client import Client

from server.base.settings import Settings


class NatsConfigurationError(Exception):
    """What the settings say cannot be used; its message is French, for the administrator."""


class TlsEnforcingClient(Client):
    """Says who it is over TLS alone, where TLS is asked for: the library follows the server, which might be another.

    The method is the library's own: a test tells if it changes.
    """

    def __init__(self, *, tls: bool) -> None:
        super().__init__()
        self._wants_tls = tls

    def _connect_command(self) -> bytes:
        if self._wants_tls and not self._server_info.get("tls_required"):
            raise ssl.SSLError("the server does not offer TLS, which is asked for")
        command: bytes = super()._connect_command()
        return command


def servers(settings: Settings) -> list[str]:
    return [one.strip() for one in settings.nats_url.split(",") if one.strip()]


def wants_tls(settings: Settings) -> bool:
    files = (settings.nats_tls_ca, settings.nats_tls_cert)
    return any(files) or any(one.startswith("tls://") for one in servers(settings))


def connect_options(settings: Settings) -> dict[str, Any]:
    """What the library's `connect` is given. Raises UnfitError."""
    found: dict[str, Any] = {"servers": servers(settings)}
    if settings.nats_token:
        found["token"] = settings.nats_token
    if settings.nats_nkey_file is not None:
        found["nkeys_seed"] = str(_readable(settings.nats_nkey_file, "BALISE_NATS_NKEY_FILE"))
    if wants_tls(settings):
        found["tls"] = _context(settings)
    return found


def _context(settings: Settings) -> ssl.SSLContext:
    ca = settings.nats_tls_ca
    try:
        context = ssl.create_default_context(cafile=ca and str(_readable(ca, "BALISE_NATS_TLS_CA")))
        if settings.nats_tls_cert is not None:
            cert = _readable(settings.nats_tls_cert, "BALISE_NATS_TLS_CERT")
            key = settings.nats_tls_key and _readable(settings.nats_tls_key, "BALISE_NATS_TLS_KEY")
            context.load_cert_chain(cert, key)
    except ssl.SSLError as error:
        raise NatsConfigurationError(f"les certificats de BALISE_NATS_TLS_… ne conviennent pas : {error}") from error
    return context


def _readable(path: Path, variable: str) -> Path:
    try:
        path.open("rb").close()
    except OSError as error:
        raise NatsConfigurationError(f"{variable} : {path} ne se lit pas ({error.strerror})") from error
    return path
