"""Notices that nobody takes the jobs that wait: neither those who wait nor an administrator would know otherwise."""

import logging
import time
from collections.abc import Callable, Collection
from uuid import UUID

from sqlalchemy.orm import Session

from server.queue.interfaces import Queue

log = logging.getLogger(__name__)

STALL_SECONDS = 15.0  # seconds: workers need some to begin


class StallWatchdog:
    """To be asked to look again and again; `unattended` since the same job has waited for `PATIENCE`, with none done.

    A long queue is no reason: its jobs are begun one after the other.
    """

    def __init__(self, queue: Queue, kinds: Collection[str], clock: Callable[[], float] = time.monotonic) -> None:
        self._queue, self._kinds, self._clock = queue, kinds, clock
        self._awaited: UUID | None = None
        self._since = clock()
        self.stalled = False

    def check(self, db: Session) -> None:
        found = self._queue.find_stalled(db, self._kinds, self._awaited)
        if found is None or found != self._awaited:
            self._awaited, self._since = found, self._clock()
        waited = self._clock() - self._since
        self._tell(found is not None and waited >= STALL_SECONDS, waited)

    def _tell(self, unattended: bool, waited: float) -> None:
        if unattended and not self.stalled:
            log.error(
                "no worker takes what waits: job %s, for %.0f s or more; does any run (BALISE_WORKERS here, or "
                "`balise worker` elsewhere)?",
                *(self._awaited, waited),
            )
        elif self.stalled and not unattended:
            log.warning("what waited is taken again")
        self.stalled = unattended
