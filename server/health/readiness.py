"""Readiness of this process: its database answers, its workers run, nobody has asked it to stop."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path

from sqlalchemy.exc import SQLAlchemyError

from server.base.concurrency import Gate
from server.base.files import MIN_FREE_BYTES, free_bytes
from server.database import Database, utc_now
from server.grading.supervisor import WorkerSupervisor
from server.health import repository

#: Without the message broker everything goes on, more slowly: the process stays ready.
BROKER_CHECK = "nats"
#: With little room on the disk it goes on too, for now.
DISK_CHECK = "disk"
#: A submission that nobody takes for so long while nothing is graded: no worker is there.
NOBODY_GRADES_AFTER = timedelta(seconds=60)


@dataclass(frozen=True)
class ReadinessChecks:
    """`broker_status` returns the state of the message broker, where there is one; `data_dir`: the disk to watch."""

    database: Database
    supervisor: WorkerSupervisor
    walls: Gate
    data_dir: Path
    broker_status: Callable[[], str] | None = None

    def run_checks(self) -> Mapping[str, str]:
        """Return `ok` or the problem of each part."""
        walls = "ok" if self.walls.is_open else "being tried"
        return {
            "database": self._check_database(),
            "walls": walls,
            "workers": self._check_workers(),
            "service": self._check_service(),
            DISK_CHECK: "ok" if free_bytes(self.data_dir) >= MIN_FREE_BYTES else "nearly full",
            **({} if self.broker_status is None else {BROKER_CHECK: self.broker_status()}),
        }

    def _check_database(self) -> str:
        try:
            with self.database.read() as db:
                repository.ping_database(db)
        except SQLAlchemyError:
            return "unreachable"
        return "ok"

    def _check_workers(self) -> str:
        """One is enough, since dead ones are restarted. With none here, other machines grade, unless work waits."""
        if self.supervisor.target_worker_count:
            return "ok" if self.supervisor.alive_worker_count() else "none"
        try:
            with self.database.read() as db:
                return "none" if repository.is_grading_abandoned(db, utc_now() - NOBODY_GRADES_AFTER) else "ok"
        except SQLAlchemyError:
            return "unknown"

    def _check_service(self) -> str:
        return "stopping" if self.supervisor.is_stopping else "ok"
