"""Documents of other systems, cached by address and fetched anew: what their servers publish, and seldom change."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Generic, TypeVar

from server.federation.errors import OutgoingError

T = TypeVar("T")


@dataclass(frozen=True)
class _Cached(Generic[T]):
    document: T
    at: float


class RemoteDocumentCache(Generic[T]):
    """Thread-safe cache. `fetch` returns the document of an address, or raises OutgoingError.

    A document that is `fresh_seconds` old is fetched again; where that fails, the earlier one stays. No address is
    asked more often than every `retry_seconds`. `most` addresses are remembered.
    """

    def __init__(
        self,
        fetch: Callable[[str], T],
        clock: Callable[[], float],
        *,
        fresh_seconds: float,
        retry_seconds: float,
        most: int,
    ) -> None:
        self._fetch, self._clock = fetch, clock
        self._fresh_seconds, self._retry_seconds, self._most = fresh_seconds, retry_seconds, most
        self._cached: dict[str, _Cached[T]] = {}
        self._tried: dict[str, float] = {}
        self._fetches: dict[str, Future[T]] = {}
        self._lock = threading.Lock()

    def find(self, address: str, suffices: Callable[[T], bool] = lambda _: True) -> T | None:
        """Return the document, fetched anew where it is old or does not suffice; None where there is none and it was
        asked for lately. Whoever comes while it is fetched waits for it, unless the earlier one suffices. Raises
        OutgoingError where there is none, and none is got."""
        fetch = own = None
        with self._lock:
            cached, now = self._cached.get(address), self._clock()
            is_enough = cached is not None and suffices(cached.document)
            if cached is not None and is_enough and now - cached.at < self._fresh_seconds:
                return cached.document
            if address in self._fetches:
                fetch = None if is_enough else self._fetches[address]
            elif now - self._tried.get(address, -self._retry_seconds) >= self._retry_seconds:
                if len(self._tried) > self._most:
                    self._tried.clear()
                    self._cached.clear()
                self._tried[address] = now
                fetch = own = self._fetches[address] = Future()
        if own is not None:
            self._fetch_for_all(address, own)
        if fetch is not None:
            try:
                return fetch.result()
            except OutgoingError:
                if cached is None:
                    raise
        return None if cached is None else cached.document

    def _fetch_for_all(self, address: str, fetch: Future[T]) -> None:
        try:
            fetch.set_result(self.refresh(address))
        except BaseException as error:
            fetch.set_exception(error)
        finally:
            with self._lock:
                del self._fetches[address]

    def refresh(self, address: str) -> T:
        """Fetch the document. Raises OutgoingError."""
        document = self._fetch(address)
        with self._lock:
            self._cached[address] = _Cached(document, self._clock())
        return document
