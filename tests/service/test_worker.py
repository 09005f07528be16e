"""The worker's step, with fakes; and the joint between sandbox and graders, for real."""

from __future__ import annotations

import hashlib
import logging
import os
import signal
import threading
import time
from collections.abc import Iterator
from typing import Any
from uuid import uuid4

import pytest
from sqlalchemy import select

from graders.core.contract.outcomes import Outcome
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from server.grading import joint as grading
from server.grading.joint import Grader
from server.grading.worker import Stop, Worker
from server.identity.models import Account
from server.queue.service import Lease
from server.sandbox import FaultKind, Sandbox, SandboxFault
from server.submissions import service as submissions
from server.submissions.models import State, Submission

from .conftest import EXERCISE, fake_grade


def submitted(database: Database, account: Account, code: str = "pass") -> None:
    with database.write() as db:
        submissions.submit(db, account, EXERCISE, code)


def only(database: Database) -> Submission:
    with database.read() as db:
        return db.execute(select(Submission)).scalar_one()


def test_a_step_grades_one_and_says_whether_it_found_work(database: Database, ada: Account, both: Settings) -> None:
    worker = Worker(database, both, fake_grade)
    assert not worker.step()
    submitted(database, ada)
    assert worker.step()
    assert not worker.step()
    row = only(database)
    assert (row.state, row.outcome, row.attempts) == (State.done, "ok", 1)
    assert row.verdict is not None
    assert row.verdict["seed"] == row.seed
    assert row.finished_at is not None


def test_a_worker_told_to_stop_gives_its_work_back(database: Database, ada: Account, both: Settings) -> None:
    def stopped(_lease: Lease) -> dict[str, Any]:
        raise Stop

    submitted(database, ada)
    with pytest.raises(Stop):
        Worker(database, both, stopped).step()
    assert (only(database).state, only(database).attempts) == (State.queued, 0)


def test_the_heartbeat_extends_the_lease_while_grading(sqlite: Database, settings: Settings) -> None:
    beating = settings.model_copy(update={"lease_seconds": 0.15})
    account = Account(name="Ada")
    with sqlite.write() as db:
        db.add(account)
    submitted(sqlite, account)
    untils: list[Any] = []

    def slow(lease: Lease) -> dict[str, Any]:
        first = only(sqlite).lease_until
        deadline = time.monotonic() + 20
        while only(sqlite).lease_until == first and time.monotonic() < deadline:
            time.sleep(0.01)
        untils.extend([first, only(sqlite).lease_until])
        return fake_grade(lease)

    class Once:
        def wait(self, seconds: float) -> bool:
            return False

    Worker(sqlite, beating, slow).run(Once())
    assert untils[1] > untils[0]
    assert only(sqlite).state == State.done


@pytest.fixture(scope="module")
def sandbox(course: Course) -> Iterator[Sandbox]:
    with Sandbox(course.kits) as one:
        yield one


@pytest.fixture
def grader(course: Course, sandbox: Sandbox) -> Grader:
    return Grader(course, sandbox)


def test_the_reference_gets_full_marks_through_the_sandbox(grader: Grader, course: Course) -> None:
    exercise = course.exercises[EXERCISE]
    verdict = grader.grade(EXERCISE, exercise.solution.encode(), seed=7).verdict
    assert (verdict.outcome, verdict.score, verdict.seed) == (Outcome.OK, 1.0, 7)
    assert verdict.exercise_version == exercise.version


def test_the_same_seed_gives_the_same_verdict(grader: Grader, course: Course) -> None:
    source = course.exercises[EXERCISE].grader.misconceptions[0].source.encode()
    one, two = (grader.grade(EXERCISE, source, seed=11).verdict.to_json() for _ in range(2))
    for verdict in (one, two):
        verdict.pop("timings")
    assert one == two


@pytest.mark.parametrize(
    ("source", "outcome", "told"),
    [
        (b"def composer(a, b)\n    return a\n", Outcome.SYNTAX_ERROR, "1"),
        (b"import tensorflow\n", Outcome.IMPORT_ERROR, "tensorflow"),
        (b"x = 1\n", Outcome.MISSING_FUNCTION, "composer"),
        (b"def composer(a, b):\n    return 1 / 0\ninverse = relatif = composer\n", Outcome.RUNTIME_ERROR, "ligne 2"),
    ],
)
def test_a_student_s_fault_keeps_its_kind_and_its_place(
    grader: Grader, source: bytes, outcome: Outcome, told: str
) -> None:
    verdict = grader.grade(EXERCISE, source, seed=1).verdict
    assert (verdict.outcome, verdict.score) == (outcome, 0)
    assert any(told in check.message for check in verdict.checks)


def test_every_fault_of_the_sandbox_has_its_outcome() -> None:
    assert {kind.value for kind in FaultKind} <= {outcome.value for outcome in Outcome}


class Failing:
    """A sandbox of ours that fails a number of times, then works."""

    def __init__(self, sandbox: Sandbox, times: int) -> None:
        self.sandbox, self.times, self.opened = sandbox, times, 0

    def open(self, *args: Any, **options: Any) -> Any:
        self.opened += 1
        if self.opened <= self.times:
            raise SandboxFault("the template is dead")
        return self.sandbox.open(*args, **options)


@pytest.mark.parametrize(("failures", "outcome"), [(1, Outcome.OK), (99, Outcome.INTERNAL_ERROR)])
def test_our_own_fault_is_retried_once_logged_and_never_a_zero(
    failures: int, outcome: Outcome, sandbox: Sandbox, course: Course, caplog: pytest.LogCaptureFixture
) -> None:
    failing = Failing(sandbox, failures)
    source = course.exercises[EXERCISE].solution.encode()
    with caplog.at_level(logging.ERROR):
        one = uuid4()
        result = Grader(course, failing).grade(EXERCISE, source, 123, submission=one)  # type: ignore[arg-type]
    assert result.verdict.outcome is outcome
    assert len(caplog.records) == min(failures, grading.TRIES)
    version, digest = course.exercises[EXERCISE].version, hashlib.sha256(source).hexdigest()
    for told in ("the template is dead", "Traceback", EXERCISE, version, "seed 123", str(one), digest):
        assert told in caplog.text


def test_sigterm_stops_a_worker_in_its_main_thread() -> None:
    from server.grading.process import stop_on_signals

    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        stop_on_signals()
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGTERM)).start()
        with pytest.raises(Stop):
            time.sleep(20)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
