"""HTTP to other machines, within walls: https, public addresses, no redirects, bounded sizes and times.

The host is resolved once, each of its addresses is checked, and the connection goes to the checked address, so that a
name cannot change between the check and the connection. Nothing of the environment (proxies, `.netrc`) is read. Calls
block: they are made in a worker's thread, or by `OutgoingThreads`, never on the event loop nor in its shared threads.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from ipaddress import IPv4Address, IPv4Network, IPv6Address, IPv6Network, ip_address, ip_network
from typing import Any, Protocol, TypeVar
from urllib.parse import urlencode, urlsplit

from server.base.errors import Overloaded
from server.base.version import VERSION
from server.federation.errors import OutgoingError

T = TypeVar("T")
MAX_ANSWER = 256 * 1024  # bytes; one page of a list of people has its own bound
CONNECT_SECONDS, READ_SECONDS, TOTAL_SECONDS = 5.0, 8.0, 12.0
MAX_URL = 2000  # characters
MAX_RETRY_AFTER = 3600.0  # seconds
THREADS, SHARE = 16, 2  # of the web process, and of one provider at most
MAX_CALLS, WAIT_SECONDS = 200, 10.0  # to one provider: in all, and for a thread of its share
BUSY = "Trop de demandes attendent le système de l’établissement : réessayez dans quelques secondes."
NAT64 = ip_network("64:ff9b::/96")
Network = IPv4Network | IPv6Network


def parse_networks(text: str) -> Sequence[Network]:
    """Parse networks separated by commas. Raises ValueError."""
    return [ip_network(piece.strip()) for piece in text.split(",") if piece.strip()]


def is_allowed_address(address: str, private: Sequence[Network]) -> bool:
    """Whether a connection may go there: a public address, or one of the administrator's own networks."""
    parsed = ip_address(address.partition("%")[0])
    if isinstance(parsed, IPv6Address):
        if parsed.is_site_local:
            return any(parsed in network for network in private if network.version == parsed.version)
        embedded = parsed.ipv4_mapped or parsed.sixtofour or (parsed.teredo[1] if parsed.teredo else None)
        if parsed in NAT64:
            embedded = IPv4Address(int(parsed) & 0xFFFFFFFF)
        if embedded is not None:
            return is_allowed_address(str(embedded), private)
    if any(parsed.version == network.version and parsed in network for network in private):
        return True
    return parsed.is_global and not parsed.is_multicast and not parsed.is_reserved


def check_url(url: str, *, insecure: bool = False) -> str:
    """Return an address that may be asked. `insecure`: http is allowed, for tests on one machine. Raises ValueError."""
    parts = urlsplit(url)
    schemes = {"https", "http"} if insecure else {"https"}
    if len(url) > MAX_URL or not url.isascii() or not url.isprintable() or " " in url or "\\" in url:
        raise ValueError("not an address")
    if parts.scheme not in schemes or not parts.hostname or parts.username is not None or parts.password is not None:
        raise ValueError("not an https address")
    if parts.fragment or parts.port == 0:
        raise ValueError("not an address of a service")
    return url


def is_url(url: str, *, insecure: bool = False) -> bool:
    """Whether an address may be asked."""
    try:
        check_url(url, insecure=insecure)
    except ValueError:
        return False
    return True


def origin_of_url(url: str) -> str:
    """Return scheme, host and port, where it is not the scheme's own; an empty text for what is no address."""
    try:
        parts = urlsplit(url)
    except ValueError:
        return ""
    own_port = {"https": ":443", "http": ":80"}.get(parts.scheme, "")
    return f"{parts.scheme}://{parts.netloc.lower().removesuffix(own_port)}"


def has_origin_in(url: str, origins: Iterable[str]) -> bool:
    """Whether an address is on one of these origins: scheme, host and port."""
    return is_url(url, insecure=True) and origin_of_url(url) in set(origins)


def with_query(url: str, parameters: Mapping[str, str]) -> str:
    """Add parameters to an address that may have some."""
    return f"{url}{'&' if urlsplit(url).query else '?'}{urlencode(parameters)}"


@dataclass(frozen=True)
class HttpAnswer:
    status: int
    headers: Mapping[str, str]
    content: bytes

    def json(self) -> Any:
        """Return the document. Raises OutgoingError."""
        try:
            return json.loads(self.content)
        except (ValueError, RecursionError):
            raise OutgoingError("la réponse n’est pas du JSON") from None


class HttpExchange(Protocol):
    """One request and its answer; see `checked_connections.CheckedConnections.exchange`."""

    def __call__(
        self,
        method: str,
        url: str,
        headers: Mapping[str, str],
        content: bytes,
        max_bytes: int,
        *,
        timeouts: tuple[float, float, float],
    ) -> tuple[int, Mapping[str, str], bytes]: ...


class Outgoing:
    """Thread-safe; one for each process. `private` are the networks of the administrator's own platforms."""

    def __init__(
        self, private: Sequence[Network] = (), *, insecure: bool = False, exchange: HttpExchange | None = None
    ) -> None:
        self._private, self.insecure, self._given = tuple(private), insecure, exchange

    @cached_property
    def _exchange(self) -> HttpExchange:
        if self._given is not None:
            return self._given
        from server.federation.checked_connections import CheckedConnections

        return CheckedConnections(lambda address: is_allowed_address(address, self._private)).exchange

    def request(
        self,
        method: str,
        url: str,
        *,
        headers: Mapping[str, str] | None = None,
        content: bytes = b"",
        most: int = MAX_ANSWER,
        accept: str = "application/json",
    ) -> HttpAnswer:
        """Return an answer with a status under 300. Raises OutgoingError, also for a redirect."""
        try:
            check_url(url, insecure=self.insecure)
        except ValueError:
            raise OutgoingError("ce n’est pas une adresse https") from None
        sent = {"Host": urlsplit(url).netloc, "User-Agent": f"Balise/{VERSION}", "Accept": accept, **(headers or {})}
        if method != "GET":
            sent["Content-Length"] = str(len(content))
        status, received, body = self._exchange(
            method, url, sent, content, most, timeouts=(CONNECT_SECONDS, READ_SECONDS, TOTAL_SECONDS)
        )
        return _require_success(HttpAnswer(status, received, body))

    def get_json(self, url: str, *, headers: Mapping[str, str] | None = None, most: int = MAX_ANSWER) -> Any:
        """Return a JSON document. Raises OutgoingError."""
        return self.request("GET", url, headers=headers, most=most).json()


def _require_success(answer: HttpAnswer) -> HttpAnswer:
    status = answer.status
    if status < 300:
        return answer
    if status < 400:
        raise OutgoingError("la réponse renvoie ailleurs, ce qui n’est pas suivi", status=status)
    told = answer.headers.get("retry-after", "")
    wait = min(float(told), MAX_RETRY_AFTER) if told.isdecimal() and len(told) < 8 else 0.0
    retry = status in {408, 425, 429} or status >= 500
    raise OutgoingError(f"réponse {status}", status=status, retry=retry, retry_after=wait)


class _ProviderThreads:
    """The threads of one provider: how many may be taken, and how many calls there are."""

    def __init__(self) -> None:
        self.free, self.calls = asyncio.Semaphore(SHARE), 0


class OutgoingThreads:
    """Threads of the web process for calls that a page waits for.

    Each provider has a share of them: one whose server hangs holds up nobody else's people. Calls that wait for a
    thread are bounded, and take none.
    """

    def __init__(self) -> None:
        self._shares: dict[Hashable, _ProviderThreads] = {}

    @cached_property
    def _threads(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(THREADS, thread_name_prefix="outgoing")

    async def run(self, owner: Hashable, work: Callable[[], T]) -> T:
        """Return the result of `work`, which asks the provider `owner`. Raises Overloaded where too many calls to it
        wait, or for too long, else as `work`."""
        share = self._shares.setdefault(owner, _ProviderThreads())
        if share.calls >= MAX_CALLS:
            raise Overloaded(BUSY, retry_after=5)
        share.calls += 1
        try:
            async with asyncio.timeout(WAIT_SECONDS):
                await share.free.acquire()
        except BaseException as error:
            self._end_call(owner, share)
            if isinstance(error, TimeoutError):
                raise Overloaded(BUSY, retry_after=5) from None
            raise
        call, loop = self._threads.submit(work), asyncio.get_running_loop()

        def release(_: object) -> None:  # also for a page whose browser has gone: the thread is busy until then
            with suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(self._end_call, owner, share, True)

        call.add_done_callback(release)
        return await asyncio.wrap_future(call)

    def _end_call(self, owner: Hashable, share: _ProviderThreads, has_thread: bool = False) -> None:
        share.calls -= 1
        if has_thread:
            share.free.release()
        if not share.calls:
            self._shares.pop(owner, None)
