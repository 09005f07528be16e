"""Readiness of this process: its database answers, its workers run, nobody has asked it to stop."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from sqlalchemy.exc import SQLAlchemyError

from server.base.concurrency import Gate
from server.database import Database
from server.grading.supervisor import WorkerSupervisor
from server.health import repository

#: Without the message broker everything goes on, more slowly: the process stays ready.
BROKER_CHECK = "nats"


@dataclass(frozen=True)
class Readiness:
    """`broker_status` returns the state of the message broker, where there is one."""

    database: Database
    supervisor: WorkerSupervisor
    walls: Gate
    broker_status: Callable[[], str] | None = None

    def checks(self) -> Mapping[str, str]:
        """Return `ok` or the problem of each part."""
        walls = "ok" if self.walls.is_open else "being tried"
        return {
            "database": self._database(),
            "walls": walls,
            "workers": self._workers(),
            "service": self._service(),
            **({} if self.broker_status is None else {BROKER_CHECK: self.broker_status()}),
        }

    def _database(self) -> str:
        try:
            with self.database.read() as db:
                repository.ping(db)
        except SQLAlchemyError:
            return "unreachable"
        return "ok"

    def _workers(self) -> str:
        """One is enough, since dead ones are restarted. With none configured, other machines grade."""
        return "ok" if self.supervisor.alive_count() or not self.supervisor.target_count else "none"

    def _service(self) -> str:
        return "stopping" if self.supervisor.stopping else "ok"
