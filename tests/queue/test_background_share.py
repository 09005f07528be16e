"""Jobs of the background, such as a regrade, go on behind a queue that is never empty. Jobs are counted, not timed."""

from __future__ import annotations

from typing import Any

from sqlalchemy.orm import Session

from server.base.settings import Settings
from server.database import Database
from server.queue.interfaces import Lease, Sender
from server.queue.relief import BACKGROUND_TURN
from server.queue.worker import Worker
from tests.support.service import QUIET

GRADE, REGRADE = "bake", "clean"
RANKS = {GRADE: 0, REGRADE: 9}


class Endless:
    """Implements `Task`: each job that ends has a successor of its kind, for as long as it is busy."""

    def __init__(self) -> None:
        self.done: list[str] = []
        self.busy = True

    def read(self, _db: Session, lease: Lease) -> str:
        return lease.kind

    def run(self, work: str) -> str:
        return work

    def record(self, db: Session, work: str, _result: str) -> None:
        self.done.append(work)
        if self.busy:
            self.put(db, work)

    def put(self, db: Session, kind: str) -> None:
        QUIET.enqueue(db, kind, f"{kind} {len(self.done)}", {}, Sender(kind, flow=kind, rank=RANKS[kind]))

    def give_up(self, _db: Session, lease: Lease) -> None:
        raise AssertionError(f"{lease.key} was given up")


def test_a_regrade_has_a_share_behind_students_who_never_stop(database: Database, both: Settings) -> None:
    task = Endless()
    tasks: Any = {GRADE: task, REGRADE: task}
    worker = Worker(database, QUIET, both, tasks, background=[REGRADE])
    with database.write() as db:
        for kind in (REGRADE, GRADE):
            task.put(db, kind)
    for _ in range(3 * BACKGROUND_TURN + 1):
        assert worker.run_one()
    regraded = [number for number, kind in enumerate(task.done) if kind == REGRADE]
    assert regraded == [BACKGROUND_TURN, 2 * BACKGROUND_TURN + 1, 3 * BACKGROUND_TURN + 2]
    task.busy = False
    while worker.run_one():
        pass
    assert task.done[-1] == REGRADE, "behind the last of the students"
