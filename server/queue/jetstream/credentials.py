"""Credentials and addresses of NATS: servers, token, nkey, TLS."""

import ssl
from pathlib import Path
from typing import Any

from nats.aio.client import Client

from server.base.settings import Settings


class NatsConfigurationError(Exception):
    """Unusable settings; its message is French, for the administrator."""


class TlsEnforcingClient(Client):
    """Sends credentials over TLS only, where TLS is required: the library would follow a server that offers none.

    It overrides a method of the library; a test notices if that changes.
    """

    def __init__(self, *, tls: bool) -> None:
        super().__init__()
        self._requires_tls = tls

    def _connect_command(self) -> bytes:
        if self._requires_tls and not self._server_info.get("tls_required"):
            raise ssl.SSLError("the server does not offer TLS, which is asked for")
        command: bytes = super()._connect_command()
        return command


def server_urls(settings: Settings) -> list[str]:
    return [url.strip() for url in settings.nats_url.split(",") if url.strip()]


def requires_tls(settings: Settings) -> bool:
    files = (settings.nats_tls_ca, settings.nats_tls_cert)
    return any(files) or any(url.startswith("tls://") for url in server_urls(settings))


def connect_options(settings: Settings) -> dict[str, Any]:
    """Return the keyword arguments of the library's `connect`. Raises NatsConfigurationError."""
    options: dict[str, Any] = {"servers": server_urls(settings)}
    if settings.nats_token:
        options["token"] = settings.nats_token
    if settings.nats_nkey_file is not None:
        options["nkeys_seed"] = str(_require_readable(settings.nats_nkey_file, "BALISE_NATS_NKEY_FILE"))
    if requires_tls(settings):
        options["tls"] = _ssl_context(settings)
    return options


def _ssl_context(settings: Settings) -> ssl.SSLContext:
    ca = settings.nats_tls_ca
    try:
        context = ssl.create_default_context(cafile=ca and str(_require_readable(ca, "BALISE_NATS_TLS_CA")))
        if settings.nats_tls_cert is not None:
            cert = _require_readable(settings.nats_tls_cert, "BALISE_NATS_TLS_CERT")
            key = settings.nats_tls_key and _require_readable(settings.nats_tls_key, "BALISE_NATS_TLS_KEY")
            context.load_cert_chain(cert, key)
    except ssl.SSLError as error:
        raise NatsConfigurationError(f"les certificats de BALISE_NATS_TLS_… ne conviennent pas : {error}") from error
    return context


def _require_readable(path: Path, variable: str) -> Path:
    try:
        path.open("rb").close()
    except OSError as error:
        raise NatsConfigurationError(f"{variable} : {path} ne se lit pas ({error.strerror})") from error
    return path
