"""The queue: one claim each, results by the lease's holder only, nothing lost."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from datetime import timedelta
from uuid import uuid4

import pytest
from sqlalchemy import select

from server.course import Course
from server.database import Database, utc_now
from server.grading.results import give_up_with
from server.identity.models import Account
from server.queue import service as queue
from server.queue.owner import is_dead, owner_of, parse
from server.queue.service import MAX_ATTEMPTS, Lease
from server.submissions.models import State, Submission

from .conftest import EXERCISE, fake_grade

HERE = owner_of(os.getpid())
GONE = replace(HERE, started="1")


def enqueue(database: Database, account: Account, count: int = 1) -> list[Submission]:
    with database.write() as db:
        rows = [
            Submission(account_id=account.id, exercise=EXERCISE, source=b"pass", digest=str(i), seed=i)
            for i in range(count)
        ]
        for row in rows:
            queue.enqueue(db, row)
    return rows


def claim(database: Database, owner: object = HERE, seconds: float = 60) -> Lease | None:
    with database.write() as db:
        return queue.claim(db, owner, seconds)  # type: ignore[arg-type]


def claimed(database: Database, owner: object = HERE, seconds: float = 60) -> Lease:
    lease = claim(database, owner, seconds)
    assert lease is not None
    return lease


def finish(database: Database, lease: Lease) -> bool:
    with database.write() as db:
        return queue.finish(db, lease, fake_grade(lease))


def state(database: Database, row: Submission) -> Submission:
    with database.read() as db:
        found = db.get(Submission, row.id)
        assert found is not None
        return found


def recover(database: Database, course: Course) -> int:
    with database.write() as db:
        return queue.recover(db, HERE, give_up_with(course))


def test_oldest_first_and_places_follow(database: Database, ada: Account) -> None:
    rows = [enqueue(database, ada)[0] for _ in range(3)]
    with database.read() as db:
        assert [queue.position(db, row) for row in rows] == [1, 2, 3]
    assert claimed(database).submission_id == rows[0].id
    with database.read() as db:
        places = [queue.position(db, state(database, row)) for row in rows]
    assert places == [None, 1, 2]


def test_an_empty_queue_gives_nothing(database: Database) -> None:
    assert claim(database) is None


def test_many_claimers_never_get_the_same_submission(database: Database, ada: Account) -> None:
    rows = enqueue(database, ada, 40)

    def drain(_: int) -> list[object]:
        found: list[object] = []
        while (lease := claim(database)) is not None:
            found.append(lease.submission_id)
        return found

    with ThreadPoolExecutor(8) as pool:
        got = Counter(one for found in pool.map(drain, range(8)) for one in found)
    # On PostgreSQL a claimer may find every waiting row locked by others, and stop early: the rest is found again.
    got.update(drain(0))
    assert got == Counter(row.id for row in rows)


def test_a_result_is_recorded_once_and_by_the_holder_only(database: Database, ada: Account) -> None:
    (row,) = enqueue(database, ada)
    lease = claimed(database)
    assert not finish(database, replace(lease, token=uuid4()))
    assert state(database, row).state == State.running
    assert finish(database, lease)
    assert not finish(database, lease)
    done = state(database, row)
    assert (done.state, done.outcome, done.score, done.lease_token) == (State.done, "ok", 1.0, None)


def test_a_lease_that_ran_out_is_taken_back_and_its_late_result_dropped(
    database: Database, ada: Account, course: Course
) -> None:
    (row,) = enqueue(database, ada)
    late = claimed(database, seconds=-1)
    assert recover(database, course) == 1
    second = claimed(database)
    assert not finish(database, late)
    assert finish(database, second)
    assert state(database, row).attempts == 2


def test_a_heartbeat_keeps_the_lease(database: Database, ada: Account, course: Course) -> None:
    enqueue(database, ada)
    lease = claimed(database, seconds=-1)
    with database.write() as db:
        assert queue.heartbeat(db, lease, 60)
    assert recover(database, course) == 0
    assert finish(database, lease)
    with database.write() as db:
        assert not queue.heartbeat(db, lease, 60)


def test_a_dead_holder_on_this_machine_loses_its_lease_at_once(
    database: Database, ada: Account, course: Course
) -> None:
    enqueue(database, ada, 2)
    claimed(database, GONE)
    alive = claimed(database, HERE)
    assert recover(database, course) == 1
    assert finish(database, alive)


def test_a_worker_s_death_frees_its_own_leases_only(database: Database, ada: Account, course: Course) -> None:
    enqueue(database, ada, 2)
    mine, other = claimed(database, GONE), claimed(database, HERE)
    with database.write() as db:
        assert queue.release(db, GONE, give_up_with(course)) == 1
    assert not finish(database, mine)
    assert finish(database, other)


def test_what_kills_its_worker_again_and_again_ends_as_our_error(
    database: Database, ada: Account, course: Course, caplog: pytest.LogCaptureFixture
) -> None:
    (row,) = enqueue(database, ada)
    for _ in range(MAX_ATTEMPTS):
        claimed(database, GONE)
        assert recover(database, course) == 1
    done = state(database, row)
    assert (done.state, done.outcome, done.score) == (State.done, "internal_error", None)
    assert done.verdict is not None
    assert done.verdict["exercise_version"] == course.exercises[EXERCISE].version
    assert claim(database) is None
    assert str(row.id) in caplog.text
    assert f"seed {done.seed}," in caplog.text
    assert f"digest {done.digest}" in caplog.text


def test_what_is_given_back_has_not_been_tried(database: Database, ada: Account) -> None:
    (row,) = enqueue(database, ada)
    lease = claimed(database)
    with database.write() as db:
        queue.give_back(db, lease)
    assert (state(database, row).state, state(database, row).attempts) == (State.queued, 0)
    assert not finish(database, lease)


def test_a_lease_of_another_machine_waits_for_its_end(database: Database, ada: Account, course: Course) -> None:
    enqueue(database, ada)
    lease = claimed(database, replace(GONE, host="elsewhere"))
    assert recover(database, course) == 0
    with database.write() as db:
        row = db.execute(select(Submission)).scalar_one()
        row.lease_until = utc_now() - timedelta(seconds=1)
    assert recover(database, course) == 1
    assert not finish(database, lease)


def test_owners_are_told_dead_or_alive() -> None:
    child = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    owner = owner_of(child.pid)
    assert parse(str(owner)) == owner
    assert not is_dead(str(owner), HERE)
    child.kill()
    child.wait()
    assert is_dead(str(owner), HERE)


@pytest.mark.parametrize(
    ("change", "dead"),
    [({"boot": "another"}, True), ({"host": "elsewhere"}, False), ({"namespace": "another"}, False), ({}, False)],
)
def test_only_certain_deaths_are_told(change: dict[str, str], dead: bool) -> None:
    assert is_dead(str(replace(HERE, **change)), HERE) is dead  # type: ignore[arg-type]
