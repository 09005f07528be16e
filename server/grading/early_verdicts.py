"""Shows the checks of a submission while the name of its mistake is still sought."""

from __future__ import annotations

import logging
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from uuid import UUID

from sqlalchemy.exc import SQLAlchemyError

from graders.core.contract.findings import Judgement
from graders.core.contract.protocol import WhileNaming
from server.database import Database
from server.gradebook import early_verdicts
from server.queue.interfaces import JOB_STARTED_SUFFIX, QueueNotifier
from server.submissions.service import job_key

log = logging.getLogger(__name__)

#: Seconds of search after which the checks are shown without the name: before that, nobody would see them.
PATIENCE_SECONDS = 0.15


class EarlyVerdictStore:
    """Stores the verdict without a diagnosis of a submission whose mistake takes long to name, and wakes its page."""

    def __init__(self, database: Database, notifier: QueueNotifier, patience: float = PATIENCE_SECONDS) -> None:
        self._database, self._notifier, self._patience = database, notifier, patience

    def show_verdict_while_naming(self, submission_id: UUID) -> WhileNaming:
        """Return the context in which a mistake is named: where that takes long, the verdict is shown without it."""

        @contextmanager
        def while_naming(judgement: Judgement) -> Iterator[None]:
            timer = threading.Timer(self._patience, self._store_early_verdict, (submission_id, judgement))
            timer.daemon = True
            timer.start()
            try:
                yield
            finally:
                timer.cancel()
                timer.join()  # what it writes is there before the grading that replaces it

        return while_naming

    def _store_early_verdict(self, submission_id: UUID, judgement: Judgement) -> None:
        """Store the verdict. Where that fails, the page waits for the whole one."""
        try:
            with self._database.write() as db:
                if early_verdicts.store_early_verdict(db, submission_id, judgement.verdict):
                    self._notifier.job_changed(db, job_key(submission_id) + JOB_STARTED_SUFFIX)
        except SQLAlchemyError:
            log.warning("the early verdict of %s was not stored", submission_id, exc_info=True)
