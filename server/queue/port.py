"""The port between whoever stores submissions, whoever grades them and whoever shows them.

The queue itself is the submissions' rows (see `server.queue.service`). These signals only save waiting: if one is lost,
a slow poll finds the same thing later.
"""

from typing import Protocol
from uuid import UUID

from sqlalchemy.orm import Session


class Signals(Protocol):
    """What a transaction tells the other processes, once it is committed."""

    def queued(self, db: Session) -> None:
        """A submission waits to be graded: an idle worker may wake up."""

    def changed(self, db: Session, submission_id: UUID) -> None:
        """A submission has changed state: whoever shows it may look again."""


class WorkSource(Protocol):
    """What a worker sleeps on."""

    def wait(self, seconds: float) -> bool:
        """Returns when there may be work, or after `seconds`; False means that the worker must stop."""


class NoSignals:
    """Nobody listens: everyone polls."""

    def queued(self, db: Session) -> None:
        return

    def changed(self, db: Session, submission_id: UUID) -> None:
        return


def signals_of(db: Session) -> Signals:
    """The signals that travel with a session (`Database(context={"signals": …})`)."""
    signals: Signals = db.info.get("signals", NoSignals())
    return signals
