"""Connections that go to checked addresses alone, and whose exchanges end in time, however slowly bytes come."""

from __future__ import annotations

import socket
import ssl
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import httpcore

from server.federation.errors import OutgoingError

SLOW = "la réponse est trop lente"
_deadline = threading.local()  # of the exchange of this thread, by the monotonic clock


def _remaining_seconds(timeout: float | None) -> float:
    """Return the seconds that may still be waited for. Raises OutgoingError."""
    left = getattr(_deadline, "at", time.monotonic()) - time.monotonic()
    if left <= 0:
        raise OutgoingError(SLOW, retry=True)
    return left if timeout is None else min(timeout, left)


class _TimedStream(httpcore.NetworkStream):
    """A stream whose waits end with the exchange."""

    def __init__(self, stream: httpcore.NetworkStream) -> None:
        self._stream = stream

    def read(self, max_bytes: int, timeout: float | None = None) -> bytes:
        return self._stream.read(max_bytes, _remaining_seconds(timeout))

    def write(self, buffer: bytes, timeout: float | None = None) -> None:
        self._stream.write(buffer, _remaining_seconds(timeout))

    def close(self) -> None:
        self._stream.close()

    def start_tls(
        self, ssl_context: ssl.SSLContext, server_hostname: str | None = None, timeout: float | None = None
    ) -> httpcore.NetworkStream:
        return _TimedStream(self._stream.start_tls(ssl_context, server_hostname, _remaining_seconds(timeout)))

    def get_extra_info(self, info: str) -> Any:
        return self._stream.get_extra_info(info)


class _CheckedBackend(httpcore.NetworkBackend):
    """Connects to a host only where all its addresses are allowed."""

    def __init__(self, is_allowed: Callable[[str], bool]) -> None:
        self._is_allowed, self._backend = is_allowed, httpcore.SyncBackend()

    def connect_tcp(
        self,
        host: str,
        port: int,
        timeout: float | None = None,
        local_address: str | None = None,
        socket_options: Iterable[Any] | None = None,
    ) -> httpcore.NetworkStream:
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)
        except OSError as error:
            raise httpcore.ConnectError(f"{host} has no address") from error
        addresses = list(dict.fromkeys(str(row[4][0]) for row in found))
        if not addresses or not all(map(self._is_allowed, addresses)):
            raise OutgoingError("cette adresse est celle d’un réseau privé")
        stream = self._backend.connect_tcp(
            addresses[0], port, _remaining_seconds(timeout), local_address, socket_options
        )
        return _TimedStream(stream)


class CheckedConnections:
    """A pool of connections. Thread-safe."""

    def __init__(self, is_allowed: Callable[[str], bool]) -> None:
        self._pool = httpcore.ConnectionPool(
            ssl_context=ssl.create_default_context(),
            max_connections=20,
            max_keepalive_connections=5,
            keepalive_expiry=20.0,
            retries=0,
            network_backend=_CheckedBackend(is_allowed),
        )

    def exchange(
        self,
        method: str,
        url: str,
        headers: Mapping[str, str],
        content: bytes,
        max_bytes: int,
        *,
        timeouts: tuple[float, float, float],
    ) -> tuple[int, Mapping[str, str], bytes]:
        """Return status, headers by lower-case names and body, of at most `max_bytes` bytes. Raises OutgoingError.

        `timeouts`, in seconds, are those of a connection, of a read or write, and of the whole.
        """
        connect, read, total = timeouts
        limits = {"connect": connect, "read": read, "write": read, "pool": connect}
        _deadline.at = time.monotonic() + total
        try:
            with self._pool.stream(
                method, url, headers=list(headers.items()), content=content, extensions={"timeout": limits}
            ) as response:
                chunks, size = [], 0
                for chunk in response.iter_stream():
                    size += len(chunk)
                    if size > max_bytes:
                        raise OutgoingError("la réponse est trop longue")
                    chunks.append(chunk)
                told = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in response.headers}
                return response.status, told, b"".join(chunks)
        except httpcore.TimeoutException as error:
            raise OutgoingError("pas de réponse à temps", retry=True) from error
        except (httpcore.NetworkError, httpcore.ProtocolError) as error:
            raise OutgoingError("pas de connexion", retry=True) from error
