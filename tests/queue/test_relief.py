"""A worker's second seat: who goes before a long job, which programs stop meanwhile, and what is given back."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest
from sqlalchemy import select
from sqlalchemy.orm import Session

from server.base.settings import Settings
from server.database import Database
from server.queue.interfaces import Lease, PrecedingJobs, Sender, WaitingJob, WorkerCapabilities
from server.queue.lease_owner import process_owner
from server.queue.models import Job
from server.queue.relief import BACKGROUND_TURN, ReliefDelays
from server.queue.worker import Worker
from server.sandbox.seat import current_seat
from tests.support.service import QUIET

KIND, BACKGROUND_KIND = "bake", "clean"
MEMBER, ACCOUNT, GUEST = 0, 1, 2
#: No time is told: jobs are let in at the second look that sees them.
AT_ONCE = ReliefDelays(look=0.005, rank=0.0, flow=0.0)
HANGING_SECONDS = 120.0  # a test that waits so long hangs


@dataclass
class Baking:
    """A job that runs: a program of its seat, and what happened to it."""

    key: str
    stopped: threading.Event = field(default_factory=threading.Event)
    goes_on: threading.Event = field(default_factory=threading.Event)
    killed: threading.Event = field(default_factory=threading.Event)
    done: threading.Event = field(default_factory=threading.Event)

    def stop(self) -> None:
        self.stopped.set()

    def go_on(self) -> None:
        self.goes_on.set()

    def kill(self) -> None:
        self.killed.set()

    __hash__ = object.__hash__


class Oven:
    """Implements `Task`: a job bakes until it is allowed to end, the oven is closed, or its programs are killed."""

    def __init__(self) -> None:
        self.began, self.recorded = list[Baking](), list[str]()
        self.closed = threading.Event()
        self._changed = threading.Condition()

    def read(self, _db: Session, lease: Lease) -> Baking:
        return Baking(lease.key)

    def run(self, work: Baking) -> Baking:
        seat = current_seat()
        assert seat is not None
        seat.add(work)
        with self._changed:
            self.began.append(work)
            self._changed.notify_all()
        while not (work.done.wait(0.002) or work.killed.is_set() or self.closed.is_set()):
            pass
        seat.remove(work)
        seat.raise_if_abandoned()
        return work

    def record(self, _db: Session, _work: Baking, result: Baking) -> None:
        with self._changed:
            self.recorded.append(result.key)
            self._changed.notify_all()

    def give_up(self, _db: Session, lease: Lease) -> None:
        raise AssertionError(f"{lease.key} was given up")

    def wait_until(self, condition: Callable[[], bool]) -> None:
        with self._changed:
            assert self._changed.wait_for(condition, HANGING_SECONDS)

    def next_beginning(self, number: int) -> Baking:
        """Wait for the job that begins as the `number`-th, from 0."""
        self.wait_until(lambda: len(self.began) > number)
        return self.began[number]

    def beginning_of(self, key: str, number: int = 0) -> Baking:
        """Wait for the `number`-th beginning of this job, from 0, whatever else begins before."""
        self.wait_until(lambda: len(self._beginnings(key)) > number)
        return self._beginnings(key)[number]

    def _beginnings(self, key: str) -> list[Baking]:
        return [baking for baking in self.began if baking.key == key]


class Bell:
    """A work source that ends when it is told to."""

    buffers_wakeups = False

    def __init__(self) -> None:
        self.ended = threading.Event()

    def wait(self, _seconds: float) -> bool:
        return not self.ended.wait(0.005)


class LookCounter:
    """A queue that counts how often it is asked what goes before a running job."""

    def __init__(self) -> None:
        self._looks, self._changed = 0, threading.Condition()

    def __getattr__(self, name: str) -> Any:
        return getattr(QUIET, name)

    def peek_next_job(self, *arguments: Any) -> WaitingJob | None:
        found = QUIET.peek_next_job(*arguments)
        with self._changed:
            self._looks += 1
            self._changed.notify_all()
        return found

    def wait_for_more(self, looks: int) -> None:
        with self._changed:
            until = self._looks + looks
            assert self._changed.wait_for(lambda: self._looks >= until, HANGING_SECONDS)


@dataclass
class Kitchen:
    database: Database
    settings: Settings
    oven: Oven = field(default_factory=Oven)
    queue: Any = QUIET

    def put(self, key: str, rank: int, flow: str, kind: str = KIND, needs: str | None = None) -> None:
        with self.database.write() as db:
            sender = Sender(flow, "here", flow=flow, rank=rank)
            QUIET.enqueue(db, kind, key, {}, sender, required_version=needs)

    @contextmanager
    def working(self, patience: ReliefDelays = AT_ONCE) -> Iterator[None]:
        tasks: Any = {KIND: self.oven, BACKGROUND_KIND: self.oven}
        options: Any = {"patience": patience, "background": [BACKGROUND_KIND]}
        worker, bell = Worker(self.database, self.queue, self.settings, tasks, **options), Bell()
        thread = threading.Thread(target=worker.run, args=(bell,), daemon=True)
        thread.start()
        try:
            yield
        finally:
            bell.ended.set()
            self.oven.closed.set()
            thread.join(HANGING_SECONDS)
        assert not thread.is_alive()

    def tries(self, key: str) -> int:
        with self.database.read() as db:
            return db.execute(select(Job.tries).where(Job.key == key)).scalar_one()

    def is_empty(self) -> bool:
        with self.database.read() as db:
            return db.execute(select(Job.id)).first() is None


@pytest.fixture
def kitchen(database: Database, both: Settings) -> Kitchen:
    return Kitchen(database, both)


def test_a_member_goes_before_a_guest_s_endless_job_whose_programs_stop_meanwhile(kitchen: Kitchen) -> None:
    kitchen.put("loop", GUEST, "there")
    kitchen.put("another loop", GUEST, "there")
    with kitchen.working():
        loop = kitchen.oven.next_beginning(0)
        assert not loop.stopped.is_set(), "nobody waits who goes before it"
        kitchen.put("answer", MEMBER, "ada")
        answer = kitchen.oven.next_beginning(1)
        assert (answer.key, loop.stopped.is_set(), loop.goes_on.is_set()) == ("answer", True, False)
        answer.done.set()
        kitchen.oven.wait_until(lambda: kitchen.oven.recorded == ["answer"])
        assert loop.goes_on.wait(HANGING_SECONDS)
        loop.done.set()
        kitchen.oven.next_beginning(2).done.set()
        kitchen.oven.wait_until(lambda: kitchen.oven.recorded == ["answer", "loop", "another loop"])
    assert kitchen.is_empty()


def test_another_flow_goes_before_too_and_the_same_one_never(kitchen: Kitchen) -> None:
    kitchen.put("loop", MEMBER, "eve")
    with kitchen.working():
        loop = kitchen.oven.next_beginning(0)
        kitchen.put("second loop", MEMBER, "eve")
        kitchen.put("lower", GUEST, "there")
        kitchen.put("answer", MEMBER, "ada")
        answer = kitchen.oven.next_beginning(1)
        assert (answer.key, loop.stopped.is_set()) == ("answer", True)
        answer.done.set()
        assert loop.goes_on.wait(HANGING_SECONDS)
        loop.done.set()
        assert kitchen.oven.next_beginning(2).key == "second loop"


def test_who_holds_the_second_seat_gives_it_to_a_higher_rank_untried(kitchen: Kitchen) -> None:
    kitchen.put("loop", GUEST, "there")
    with kitchen.working():
        kitchen.oven.next_beginning(0)
        kitchen.put("loop elsewhere", GUEST, "elsewhere")
        elsewhere = kitchen.oven.next_beginning(1)
        kitchen.put("answer", MEMBER, "ada")
        answer = kitchen.oven.next_beginning(2)
        assert (answer.key, elsewhere.killed.is_set()) == ("answer", True)
        assert kitchen.tries("loop elsewhere") == 0
        answer.done.set()
        kitchen.oven.wait_until(lambda: kitchen.oven.recorded == ["answer"])


def test_a_job_that_was_stopped_for_long_is_given_back_untried_and_done_later(kitchen: Kitchen) -> None:
    kitchen.put("loop", GUEST, "there")
    with kitchen.working(ReliefDelays(look=0.005, rank=0.0, flow=0.0, stopped=0.05)):
        loop = kitchen.oven.next_beginning(0)
        kitchen.put("answer", MEMBER, "ada")
        answer = kitchen.oven.beginning_of("answer")
        assert loop.killed.wait(HANGING_SECONDS)
        again = kitchen.oven.beginning_of("loop", 1)  # on a busy machine, perhaps before the answer begins
        assert kitchen.tries("loop") == 1
        answer.done.set()
        again.done.set()
        kitchen.oven.wait_until(lambda: len(kitchen.oven.recorded) == 2)
        assert kitchen.oven.recorded.count("loop") == 1
    assert kitchen.is_empty()


def test_a_job_claimed_beside_a_long_one_of_the_second_seat_has_not_been_stopped(kitchen: Kitchen) -> None:
    kitchen.queue = looks = LookCounter()
    kitchen.put("loop", GUEST, "there")
    with kitchen.working(ReliefDelays(look=0.005, rank=0.0, flow=0.0, stopped=0.05)):
        loop = kitchen.oven.next_beginning(0)
        kitchen.put("answer", MEMBER, "ada")
        kitchen.oven.beginning_of("answer")
        assert loop.killed.wait(HANGING_SECONDS)
        again = kitchen.oven.beginning_of("loop", 1)
        looks.wait_for_more(10)
        assert not again.killed.is_set()
        assert not again.stopped.is_set()
        assert len(kitchen.oven.began) == 3


def test_a_job_of_the_background_goes_on_for_a_moment_behind_many_others(kitchen: Kitchen) -> None:
    kitchen.put("regrade", GUEST, "class", kind=BACKGROUND_KIND)
    with kitchen.working():
        regrade = kitchen.oven.next_beginning(0)
        for number in range(BACKGROUND_TURN + 1):
            kitchen.put(f"answer {number}", MEMBER, f"student {number}")
        for number in range(BACKGROUND_TURN):
            assert not regrade.goes_on.is_set()
            kitchen.oven.next_beginning(1 + number).done.set()
        kitchen.oven.next_beginning(1 + BACKGROUND_TURN)
        assert regrade.goes_on.is_set(), "before the next of the others"
        assert not regrade.killed.is_set()


def test_a_worker_that_ends_gives_the_job_of_its_second_seat_back_untried(kitchen: Kitchen) -> None:
    tasks: Any = {KIND: kitchen.oven}
    worker, bell = Worker(kitchen.database, QUIET, kitchen.settings, tasks, patience=AT_ONCE), Bell()
    kitchen.put("loop", GUEST, "there")
    thread = threading.Thread(target=worker.run, args=(bell,), daemon=True)
    thread.start()
    loop = kitchen.oven.next_beginning(0)
    kitchen.put("answer", MEMBER, "ada")
    answer = kitchen.oven.next_beginning(1)
    bell.ended.set()
    loop.done.set()
    thread.join(HANGING_SECONDS)
    assert (thread.is_alive(), answer.killed.is_set(), kitchen.oven.recorded) == (False, True, ["loop"])
    assert kitchen.tries("answer") == 0


@pytest.mark.parametrize("capable", [False, True])
def test_what_goes_before_a_running_job(kitchen: Kitchen, capable: bool) -> None:
    able = WorkerCapabilities(["new"], 60.0) if capable else None

    def key_of(among: PrecedingJobs) -> str | None:
        with kitchen.database.read() as db:
            waiting = QUIET.peek_next_job(db, [KIND], among, able)
            return None if waiting is None else db.execute(select(Job.key).where(Job.id == waiting.job_id)).scalar_one()

    kitchen.put("guest", GUEST, "there")
    kitchen.put("other guest", GUEST, "elsewhere")
    kitchen.put("other kind", MEMBER, "ada", kind="mill")
    if capable:
        kitchen.put("other version", MEMBER, "ada", needs="old")
    assert key_of(PrecedingJobs(GUEST, GUEST, "there")) == "other guest"
    assert key_of(PrecedingJobs(GUEST)) is None
    kitchen.put("account", ACCOUNT, "bob", needs="new" if capable else None)
    assert key_of(PrecedingJobs(GUEST, GUEST, "there")) == "account"
    assert key_of(PrecedingJobs(ACCOUNT)) is None
    with kitchen.database.write() as db:
        lease = QUIET.claim(db, process_owner(os.getpid()), [KIND], 60.0, able, PrecedingJobs(GUEST))
    assert lease is not None
    assert (lease.key, lease.rank, lease.flow) == ("account", ACCOUNT, "bob")
