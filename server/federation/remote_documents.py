"""Documents of other systems, cached by address and fetched anew: what their servers publish, and seldom change."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from server.federation.errors import OutgoingError

T = TypeVar("T")


@dataclass(frozen=True)
class _Cached(Generic[T]):
    document: T
    at: float


class RemoteDocuments(Generic[T]):
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
        self._lock = threading.Lock()

    def find(self, address: str, suffices: Callable[[T], bool] = lambda _: True) -> T | None:
        """Return the document, fetched anew where it is old or does not suffice; None where there is none and it was
        asked for lately. Raises OutgoingError where there is none, and none is got."""
        with self._lock:
            cached, now = self._cached.get(address), self._clock()
            if cached is not None and now - cached.at < self._fresh_seconds and suffices(cached.document):
                return cached.document
            may_ask = now - self._tried.get(address, -self._retry_seconds) >= self._retry_seconds
            if may_ask:
                if len(self._tried) > self._most:
                    self._tried.clear()
                    self._cached.clear()
                self._tried[address] = now
        if may_ask:
            try:
                return self.refresh(address)
            except OutgoingError:
                if cached is None:
                    raise
        return None if cached is None else cached.document

    def refresh(self, address: str) -> T:
        """Fetch the document. Raises OutgoingError."""
        document = self._fetch(address)
        with self._lock:
            self._cached[address] = _Cached(document, self._clock())
        return document
