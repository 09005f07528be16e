"""Counters of what happens in this process, since it began: who counts needs no library, who shows them has one."""

import secrets
import threading
import time
from collections import Counter, deque
from collections.abc import Mapping

from cachetools import TTLCache


class LabelCounter:
    """Counts by the value of one label. For several threads."""

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
    """Who asked for something in the last minutes, and how much was asked in the last ones. For several threads.

    Of a visitor a number is kept that no other process could make, and for no longer: neither address nor session.
    """

    def __init__(self, seconds: float = 300.0, most: int = 100_000) -> None:
        self._seconds = seconds
        self._seen: TTLCache[int, None] = TTLCache(most, seconds)
        self._asked: deque[tuple[int, int]] = deque()  # by second
        self._salt = secrets.token_bytes(16)
        self._lock = threading.Lock()

    def record(self, visitor: bytes) -> None:
        second = int(time.monotonic())
        with self._lock:
            self._seen[hash((self._salt, visitor))] = None
            count = self._asked.pop()[1] if self._asked and self._asked[-1][0] == second else 0
            self._asked.append((second, count + 1))
            while self._asked[0][0] <= second - MINUTE:
                self._asked.popleft()

    def recent_visitors(self) -> int:
        with self._lock:
            self._seen.expire()
            return len(self._seen)

    def requests_in_last_minute(self) -> int:
        since = int(time.monotonic()) - MINUTE
        with self._lock:
            return sum(count for second, count in self._asked if second > since)


MINUTE = 60
VISITS = VisitCounter()
#: By why: `password`, `disabled`, `too_many`, `token`.
REFUSED_LOGINS = LabelCounter()
#: By what: `ticket`, `news`, `answer`; all are made up for later.
DROPPED_NOTIFICATIONS = LabelCounter()
#: By why: `worn`, `failed`; told by this machine's workers.
TEMPLATE_RENEWALS = LabelCounter()
