"""Counters of what happens in this process, since it began: who counts needs no library, who shows them has one."""

import threading
from collections import Counter
from collections.abc import Mapping


class Tally:
    """Counts by the value of one label. For several threads."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._lock = threading.Lock()

    def add(self, label: str) -> None:
        with self._lock:
            self._counts[label] += 1

    def read(self) -> Mapping[str, int]:
        with self._lock:
            return dict(self._counts)


#: By why: `password`, `disabled`, `too_many`, `token`.
REFUSED_LOGINS = Tally()
#: By what: `ticket`, `news`, `answer`; all are made up for later.
UNPOSTED = Tally()
#: By why: `worn`, `failed`; told by this machine's workers.
TEMPLATE_RENEWALS = Tally()
