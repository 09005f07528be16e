"""Counters of events in this process since its start, without a dependency on Prometheus."""

import secrets
import threading
import time
from collections import Counter, deque
from collections.abc import Mapping

from cachetools import TTLCache


class LabelCounter:
    """Counts by the value of one label. Thread-safe."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()

    def add(self, label: str) -> None:
        with self._lock:
            self._counts[label] += 1

    def counts(self) -> Mapping[str, int]:
        with self._lock:
            return dict(self._counts)


class VisitCounter:
    """Visitors of the last minutes, and requests of the last minute. Thread-safe.

    A visitor is stored as a salted hash of this process, until it expires: neither address nor session.
    """

    def __init__(self, seconds: float = 300.0, max_visitors: int = 100_000) -> None:
        self._seconds = seconds
        self._seen: TTLCache[int, None] = TTLCache(max_visitors, seconds)
        self._requests: deque[tuple[int, int]] = deque()  # by second
        self._salt = secrets.token_bytes(16)
        self._lock = threading.Lock()

    def record(self, visitor: bytes) -> None:
        second = int(time.monotonic())
        with self._lock:
            self._seen[hash((self._salt, visitor))] = None
            count = self._requests.pop()[1] if self._requests and self._requests[-1][0] == second else 0
            self._requests.append((second, count + 1))
            while self._requests[0][0] <= second - MINUTE:
                self._requests.popleft()

    def recent_visitors(self) -> int:
        with self._lock:
            self._seen.expire()
            return len(self._seen)

    def requests_in_last_minute(self) -> int:
        since = int(time.monotonic()) - MINUTE
        with self._lock:
            return sum(count for second, count in self._requests if second > since)


MINUTE = 60
VISITS = VisitCounter()
#: By reason: `password`, `disabled`, `too_many`, `token`.
REFUSED_LOGINS = LabelCounter()
#: Notifications dropped, by kind: `ticket`, `news`, `answer`; polling makes up for them.
DROPPED_NOTIFICATIONS = LabelCounter()
#: By reason: `worn`, `failed`; reported by this machine's workers.
TEMPLATE_RENEWALS = LabelCounter()
