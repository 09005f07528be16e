"""A watchdog that reports a stalled queue: neither users nor administrators would notice otherwise."""

import logging
import time
from collections.abc import Callable, Collection
from uuid import UUID

from sqlalchemy.orm import Session

from server.queue.interfaces import Queue

log = logging.getLogger(__name__)

STALL_SECONDS = 15.0  # workers need some to start


class StallWatchdog:
    """Checked at intervals; `stalled` once the same job has waited for STALL_SECONDS while none was running.

    A long queue alone is no stall: its jobs are claimed one after the other.
    """

    def __init__(self, queue: Queue, kinds: Collection[str], clock: Callable[[], float] = time.monotonic) -> None:
        self._queue, self._kinds, self._clock = queue, kinds, clock
        self._waiting_job: UUID | None = None
        self._since = clock()
        self.stalled = False

    def check(self, db: Session) -> None:
        job_id = self._queue.find_stalled(db, self._kinds, self._waiting_job)
        if job_id is None or job_id != self._waiting_job:
            self._waiting_job, self._since = job_id, self._clock()
        waited = self._clock() - self._since
        self._update(job_id is not None and waited >= STALL_SECONDS, waited)

    def _update(self, stalled: bool, waited: float) -> None:
        if stalled and not self.stalled:
            log.error(
                "no worker takes what waits: job %s, for %.0f s or more; does any run (BALISE_WORKERS here, or "
                "`balise worker` elsewhere)?",
                *(self._waiting_job, waited),
            )
        elif self.stalled and not stalled:
            log.warning("what waited is taken again")
        self.stalled = stalled
