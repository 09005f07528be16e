"""The watch says when nobody takes what waits, once, and when somebody does again; a long queue is no reason."""

from __future__ import annotations

import os

import pytest

from server.database import Database
from server.queue.interfaces import Lease, NullNotifier, Sender
from server.queue.lease_owner import process_owner
from server.queue.service import TableQueue
from server.queue.watchdog import STALL_SECONDS, StallWatchdog

QUEUE, HERE, KIND = TableQueue(NullNotifier()), process_owner(os.getpid()), "bake"


class Watched:
    """A queue, a watch on it, and a clock that is set by hand."""

    def __init__(self, database: Database) -> None:
        self.database, self.now = database, 0.0
        self.watch = StallWatchdog(QUEUE, [KIND], lambda: self.now)

    def put(self, key: str, sender: Sender | None = None, kind: str = KIND) -> None:
        with self.database.write() as db:
            QUEUE.enqueue(db, kind, key, {}, sender or Sender())

    def claim(self) -> Lease:
        with self.database.write() as db:
            lease = QUEUE.claim(db, HERE, [KIND], 60)
        assert lease is not None
        return lease

    def finish(self, lease: Lease) -> None:
        with self.database.write() as db:
            assert QUEUE.finish(db, lease)

    def look(self, later: float = 0.0) -> bool:
        self.now += later
        with self.database.read() as db:
            self.watch.check(db)
        return self.watch.stalled


@pytest.fixture
def watched(database: Database) -> Watched:
    return Watched(database)


def test_stalled_queue_and_its_recovery_are_logged_once(watched: Watched, caplog: pytest.LogCaptureFixture) -> None:
    assert not watched.look(1000), "nothing waits"
    watched.put("a")
    assert not watched.look()
    watched.put("b", Sender("who comes before", rank=-1))
    assert not watched.look(STALL_SECONDS / 2)
    assert watched.look(STALL_SECONDS / 2), "a newcomer that comes first changes nothing"
    assert watched.look(1000)
    lease = watched.claim()
    assert not watched.look(1)
    watched.finish(lease)
    assert not watched.look(1), "the other one waits, but since a moment only"
    assert [record.levelname for record in caplog.records] == ["ERROR", "WARNING"]
    assert watched.look(STALL_SECONDS)


def test_a_long_queue_is_no_reason(watched: Watched) -> None:
    for number in range(4):
        watched.put(str(number))
    for _ in range(3):
        lease = watched.claim()
        assert not watched.look(3 * STALL_SECONDS), "one is being done"
        watched.finish(lease)
        assert not watched.look(), "and none is, for now"


def test_jobs_of_other_kinds_do_not_count_as_stalled(watched: Watched) -> None:
    watched.put("a", kind="mail")
    assert not watched.look()
    assert not watched.look(1000)
