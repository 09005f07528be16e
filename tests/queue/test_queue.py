"""The queue: one claim each, ended by the lease's holder only, nothing lost. It knows not what its jobs are about."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import timedelta
from typing import Any
from uuid import uuid4

import pytest
from sqlalchemy import select
from sqlalchemy.orm import Session

from server.course import Course
from server.database import Database, utc_now
from server.gradebook import service as gradebook
from server.grading.grading_task import give_up_handlers
from server.identity.models import Account
from server.queue.interfaces import JobNotification, Lease, Sender
from server.queue.lease_owner import is_owner_dead, parse_owner, process_owner
from server.queue.models import Job
from server.queue.service import MAX_TRIES, TableQueue
from server.submissions.models import SubmissionState
from server.submissions.service import GRADE, GradingProgress, SubmissionService
from tests.support.service import ADDRESS, EXERCISE

HERE = process_owner(os.getpid())
GONE = replace(HERE, start_time="1")
KIND = "bake"


class Told:
    """What the queue signals."""

    def __init__(self) -> None:
        self.queue, self.news, self.calls = TableQueue(self), list[str](), list[JobNotification]()

    def job_queued(self, db: Session, call: JobNotification, /) -> None:
        self.news.append("queued")
        self.calls.append(call)

    def job_changed(self, db: Session, news: str) -> None:
        self.news.append(news)


class Bakery:
    """A queue of loaves on a database."""

    def __init__(self, database: Database) -> None:
        self.database, self.given_up = database, list[str]()
        self.told = Told()
        self.queue = self.told.queue

    def put(self, *keys: str, kind: str = KIND, priority: int = 0) -> None:
        for key in keys:
            with self.database.write() as db:
                self.queue.enqueue(db, kind, key, {"of": "rye"}, Sender(rank=priority))

    def claim(self, owner: object = HERE, seconds: float = 60, kinds: tuple[str, ...] = (KIND,)) -> Lease | None:
        with self.database.write() as db:
            return self.queue.claim(db, owner, kinds, seconds)  # type: ignore[arg-type]

    def claimed(self, owner: object = HERE, seconds: float = 60) -> Lease:
        lease = self.claim(owner, seconds)
        assert lease is not None
        return lease

    def finish(self, lease: Lease) -> bool:
        with self.database.write() as db:
            return self.queue.finish(db, lease)

    def recover(self) -> int:
        with self.database.write() as db:
            return self.queue.recover_lost(db, HERE, {KIND: self._give_up})

    def release(self, owner: object) -> int:
        with self.database.write() as db:
            return self.queue.recover_from(db, owner, {KIND: self._give_up})  # type: ignore[arg-type]

    def _give_up(self, db: Session, lease: Lease) -> None:
        self.given_up.append(lease.key)

    def places(self, *keys: str) -> list[int | None]:
        with self.database.read() as db:
            return [self.queue.position(db, KIND, key) for key in keys]

    def jobs(self) -> list[Job]:
        with self.database.read() as db:
            return list(db.execute(select(Job)).scalars())


@pytest.fixture
def bakery(database: Database) -> Bakery:
    return Bakery(database)


def test_a_queue_without_signals_cannot_be_made() -> None:
    make: Any = TableQueue
    with pytest.raises(TypeError):
        make()


def test_lower_priorities_first_then_the_oldest_and_places_follow(bakery: Bakery) -> None:
    bakery.put("a", "b")
    bakery.put("late", priority=5)
    bakery.put("urgent", priority=-1)
    assert bakery.places("urgent", "a", "b", "late") == [1, 2, 3, 4]
    lease = bakery.claimed()
    assert (lease.key, lease.kind, lease.payload, lease.tries) == ("urgent", KIND, {"of": "rye"}, 1)
    assert bakery.places("urgent", "a", "b", "late") == [0, 1, 2, 3]
    assert bakery.finish(lease)
    assert bakery.places("urgent", "a", "unheard of") == [None, 1, None]
    assert [bakery.claimed().key for _ in range(3)] == ["a", "b", "late"]


def test_a_claim_tells_whether_others_wait_of_the_kinds_asked_for(bakery: Bakery) -> None:
    bakery.put("a", "b")
    bakery.put("letter", kind="mail")
    assert bakery.claimed().more_waiting
    assert not bakery.claimed().more_waiting, "neither what is begun nor another kind waits"
    bakery.put("c")
    lease = bakery.claim(kinds=(KIND, "mail"))
    assert lease is not None
    assert lease.more_waiting


def test_an_empty_queue_gives_nothing(bakery: Bakery) -> None:
    assert bakery.claim() is None


def test_only_jobs_of_known_kinds_are_claimed_and_recovered(bakery: Bakery) -> None:
    bakery.put("x", kind="mail")
    assert bakery.claim() is None
    assert bakery.claim(GONE, kinds=(KIND, "mail")) is not None
    assert bakery.recover() == 0
    assert bakery.release(GONE) == 0


def test_many_claimers_never_get_the_same_job(bakery: Bakery) -> None:
    keys = [str(number) for number in range(40)]
    bakery.put(*keys)

    def drain(_: int) -> list[str]:
        mine: list[str] = []
        while (lease := bakery.claim()) is not None:
            mine.append(lease.key)
        return mine

    with ThreadPoolExecutor(8) as pool:
        got = Counter(key for mine in pool.map(drain, range(8)) for key in mine)
    # On PostgreSQL a claimer may find every waiting row locked by others, and stop early: the rest is found again.
    got.update(drain(0))
    assert got == Counter(keys)


def test_a_job_is_ended_once_and_by_the_holder_only(bakery: Bakery) -> None:
    bakery.put("a")
    lease = bakery.claimed()
    assert not bakery.finish(replace(lease, token=uuid4()))
    assert bakery.places("a") == [0]
    assert bakery.finish(lease)
    assert not bakery.finish(lease)
    assert bakery.jobs() == []


def test_each_change_is_signalled_by_the_job_s_key(bakery: Bakery) -> None:
    bakery.put("a")
    bakery.finish(bakery.claimed())
    assert bakery.told.news == ["queued", "a begun", "a"]


def test_a_lease_that_ran_out_is_taken_back_and_its_late_end_refused(bakery: Bakery) -> None:
    bakery.put("a")
    late = bakery.claimed(seconds=-1)
    assert bakery.recover() == 1
    second = bakery.claimed()
    assert second.tries == 2
    assert not bakery.finish(late)
    assert bakery.finish(second)


def test_a_heartbeat_keeps_the_lease(bakery: Bakery) -> None:
    bakery.put("a")
    lease = bakery.claimed(seconds=-1)
    with bakery.database.write() as db:
        assert bakery.queue.heartbeat(db, lease, 60)
    assert bakery.recover() == 0
    assert bakery.finish(lease)
    with bakery.database.write() as db:
        assert not bakery.queue.heartbeat(db, lease, 60)


def test_a_dead_holder_on_this_machine_loses_its_lease_at_once(bakery: Bakery) -> None:
    bakery.put("a", "b")
    bakery.claimed(GONE)
    alive = bakery.claimed(HERE)
    assert bakery.recover() == 1
    assert bakery.finish(alive)


def test_a_worker_s_death_frees_its_own_leases_only(bakery: Bakery) -> None:
    bakery.put("a", "b")
    mine, other = bakery.claimed(GONE), bakery.claimed(HERE)
    assert bakery.release(GONE) == 1
    assert not bakery.finish(mine)
    assert bakery.finish(other)


def test_job_that_kills_its_workers_repeatedly_is_given_up(bakery: Bakery) -> None:
    bakery.put("a", "b")
    for _ in range(MAX_TRIES):
        assert bakery.given_up == []
        bakery.claimed(GONE)
        assert bakery.recover() == 1
    assert bakery.given_up == ["a"]
    assert [job.key for job in bakery.jobs()] == ["b"]


def test_a_submission_given_up_is_our_error_and_costs_nothing(
    database: Database, store: SubmissionService, ada: Account, course: Course, caplog: pytest.LogCaptureFixture
) -> None:
    with database.write() as db:
        sent = store.submit(db, ada, EXERCISE, "pass", address=ADDRESS)
    queue = Told().queue
    for _ in range(MAX_TRIES):
        with database.write() as db:
            assert queue.claim(db, GONE, [GRADE], 60)
            assert queue.recover_from(db, GONE, give_up_handlers(course)) == 1
    with database.read() as db:
        attempt = gradebook.find_attempt(db, ada, sent.id)
        assert store.progress(db, attempt.submission) == GradingProgress(SubmissionState.done)
        grading = attempt.grading
        assert grading is not None
        assert (grading.outcome, grading.score) == ("internal_error", None)
        assert grading.exercise_version == course.exercises[EXERCISE].version
        assert gradebook.load_progress(db, ada) == {}
    for told in (str(sent.id), f"seed {sent.seed},", f"digest {sent.digest}"):
        assert told in caplog.text


def test_requeued_job_does_not_count_the_try(bakery: Bakery) -> None:
    bakery.put("a")
    lease = bakery.claimed()
    with bakery.database.write() as db:
        bakery.queue.requeue_untried(db, lease)
    (job,) = bakery.jobs()
    assert (job.lease_token, job.started_at, job.tries) == (None, None, 0)
    assert not bakery.finish(lease)


def test_a_lease_of_another_machine_waits_for_its_end(bakery: Bakery) -> None:
    bakery.put("a")
    lease = bakery.claimed(replace(GONE, host="elsewhere"))
    assert bakery.recover() == 0
    with bakery.database.write() as db:
        job = db.execute(select(Job)).scalar_one()
        job.lease_until = utc_now() - timedelta(seconds=1)
    assert bakery.recover() == 1
    assert not bakery.finish(lease)


def test_lease_owner_of_a_process_is_dead_or_alive() -> None:
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    owner = process_owner(child.pid)
    assert parse_owner(str(owner)) == owner
    assert not is_owner_dead(str(owner), HERE)
    child.kill()
    child.wait()
    assert is_owner_dead(str(owner), HERE)


@pytest.mark.parametrize(
    ("change", "dead"),
    [
        ({"boot_id": "another"}, True),
        ({"host": "elsewhere"}, False),
        ({"pid_namespace": "another"}, False),
        ({}, False),
    ],
)
def test_owner_is_dead_only_when_certain(change: dict[str, str], dead: bool) -> None:
    assert is_owner_dead(str(replace(HERE, **change)), HERE) is dead  # type: ignore[arg-type]
