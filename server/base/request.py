"""What is read of any request, whoever asks."""

from __future__ import annotations

from starlette.requests import HTTPConnection

SAFE_METHODS = frozenset({"GET", "HEAD", "OPTIONS"})
COOKIE = "balise_session"


def client_address(connection: HTTPConnection) -> str:
    return connection.client.host if connection.client else "inconnue"
