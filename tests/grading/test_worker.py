"""The worker's step, with fakes; and the joint between sandbox and graders, for real."""

from __future__ import annotations

import hashlib
import itertools
import logging
import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from typing import Any, TypeVar
from uuid import uuid4

import numpy as np
import pytest
from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, Reply, StudentFault
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from server.gradebook.models import Grading
from server.gradebook.schemas import GradingResult
from server.grading import sandbox_grader as grading
from server.grading.grading_task import GradingInput, GradingTask, give_up_handlers
from server.grading.sandbox_grader import SandboxGrader, SandboxPrograms
from server.identity.models import Account
from server.queue.graceful_stop import GracefulStop, StopRequested
from server.queue.interfaces import Lease, Sender
from server.queue.job_runner import LeaseHeartbeat, _backoff
from server.queue.lease_owner import process_owner
from server.queue.models import Job
from server.queue.polling import PollingSource
from server.queue.worker import Worker
from server.sandbox import FaultKind, Sandbox, SandboxFault
from server.submissions.models import Submission
from server.submissions.service import GRADE, SubmissionService
from tests.support.counting import Counted
from tests.support.quick import the_course
from tests.support.service import ADDRESS, EXERCISE, QUIET, fake_grade, new_account, worker_of

Row = TypeVar("Row")


def submitted(database: Database, settings: Settings, account: Account, code: str = "pass") -> Submission:
    with database.write() as db:
        return SubmissionService(settings, QUIET).submit(db, account, EXERCISE, code, address=ADDRESS)


def only(database: Database, table: type[Row]) -> Row:
    with database.read() as db:
        return db.execute(select(table)).scalar_one()


def none(database: Database, table: type[Row]) -> bool:
    with database.read() as db:
        return db.execute(select(table)).first() is None


def test_a_step_grades_one_and_says_whether_it_found_work(database: Database, ada: Account, both: Settings) -> None:
    worker = worker_of(database, both)
    assert not worker.run_one()
    submitted(database, both, ada)
    assert worker.run_one()
    assert not worker.run_one()
    submission, grading = only(database, Submission), only(database, Grading)
    assert (submission.grading_id, grading.submission_id) == (grading.id, submission.id)
    assert (grading.outcome, grading.score, grading.seed) == (Outcome.OK, 1.0, submission.seed)
    assert grading.verdict["seed"] == submission.seed
    assert submission.created_at <= grading.started_at <= grading.finished_at
    assert none(database, Job)


def test_a_worker_told_to_stop_gives_its_work_back(database: Database, ada: Account, both: Settings) -> None:
    def stopped(_sent: GradingInput) -> Judgement:
        raise StopRequested

    submitted(database, both, ada)
    with pytest.raises(StopRequested):
        worker_of(database, both, stopped).run_one()
    job = only(database, Job)
    assert (job.lease_token, job.tries) == (None, 0)


def test_a_worker_told_to_stop_as_it_claims_gives_its_work_back_too(
    database: Database, ada: Account, both: Settings
) -> None:
    """A transaction is not cut: what it has claimed would wait for the end of the lease."""
    stopping, graded = GracefulStop(), list[GradingInput]()

    class Claiming(GradingTask):
        def read(self, db: Session, lease: Lease) -> GradingInput | None:
            stopping.request_stop()
            return super().read(db, lease)

    def grade(sent: GradingInput) -> Judgement:
        graded.append(sent)
        return fake_grade(sent)

    submitted(database, both, ada)
    worker = Worker(database, QUIET, both, {GRADE: Claiming(the_course(), grade)}, graceful_stop=stopping)
    with pytest.raises(StopRequested):
        worker.run(PollingSource())
    job = only(database, Job)
    assert (job.lease_token, job.tries, graded) == (None, 0, [])


def test_a_worker_told_to_stop_as_it_records_ends_what_it_has_done(
    database: Database, ada: Account, both: Settings
) -> None:
    stopping = GracefulStop()

    class Recording(GradingTask):
        def record(self, db: Session, work: GradingInput, result: GradingResult) -> None:
            stopping.request_stop()
            super().record(db, work, result)

    submitted(database, both, ada)
    submitted(database, both, ada)
    worker = Worker(database, QUIET, both, {GRADE: Recording(the_course(), fake_grade)}, graceful_stop=stopping)
    with pytest.raises(StopRequested):
        worker.run(PollingSource())
    assert only(database, Grading).outcome == Outcome.OK
    assert only(database, Job).lease_token is None


def test_what_fails_is_tried_again_then_given_up_as_our_error(
    database: Database, ada: Account, both: Settings, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(_sent: GradingInput) -> Judgement:
        raise RuntimeError("a disk is full")

    submitted(database, both, ada)
    worker = worker_of(database, both, broken)
    assert [worker.run_one() for _ in range(4)] == [True, True, True, False]
    assert only(database, Grading).outcome == Outcome.INTERNAL_ERROR
    assert caplog.text.count("RuntimeError: a disk is full") == 3


class Broken:
    """Jobs that say nothing."""

    def __init__(self) -> None:
        self.given_up = 0

    def read(self, db: Session, lease: Lease) -> str:
        if lease.payload == {"what": "a question of ours that no database understands"}:
            db.execute(select(Job).where(Job.key == object()))
        return str(lease.payload["what"])

    def run(self, work: str) -> str:
        return work

    def record(self, _db: Session, _work: str, _result: str) -> None:
        raise NotImplementedError

    def give_up(self, _db: Session, _lease: Lease) -> None:
        self.given_up += 1


@pytest.mark.parametrize(
    "payload",
    [{}, {"what": "nothing that can be recorded"}, {"what": "a question of ours that no database understands"}],
)
def test_a_job_that_cannot_be_read_or_recorded_stops_nobody_for_ever(
    database: Database, both: Settings, payload: dict[str, str]
) -> None:
    task = Broken()
    worker = Worker(database, QUIET, both, {"say": task})
    with database.write() as db:
        QUIET.enqueue(db, "say", "a", payload)
    assert [worker.run_one() for _ in range(4)] == [True, True, True, False]
    assert task.given_up == 1
    assert none(database, Job)


def test_work_whose_author_has_gone_is_dropped(database: Database, ada: Account, both: Settings) -> None:
    def forget(_sent: GradingInput) -> Judgement:
        with database.write() as db:
            db.execute(delete(Account))
        return fake_grade(_sent)

    submitted(database, both, ada)
    submitted(database, both, ada)
    worker = worker_of(database, both, forget)
    assert [worker.run_one() for _ in range(3)] == [True, True, False]
    assert none(database, Job)
    assert none(database, Grading)


def test_a_kind_that_nobody_here_can_do_is_left_alone(database: Database, ada: Account, both: Settings) -> None:
    with database.write() as db:
        QUIET.enqueue(db, "mail", "to Ada", {"subject": "hello"}, Sender(rank=-1))
    submitted(database, both, ada)
    worker = worker_of(database, both)
    assert [worker.run_one() for _ in range(2)] == [True, False]
    job = only(database, Job)
    assert (job.kind, job.payload, job.tries) == ("mail", {"subject": "hello"}, 0)


def test_a_worker_outlives_a_locked_database(
    sqlite: Database, settings: Settings, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As when a backup or a migration holds SQLite's only pen for longer than the driver waits."""
    account = Account(name="Ada")
    with sqlite.write() as db:
        db.add(account)
    submitted(sqlite, settings, account)
    monkeypatch.setattr("server.database.write_turns.BUSY_TIMEOUT_SECONDS", 0.001)
    monkeypatch.setattr("server.queue.job_runner.LOCKED_PAUSE", 0.01)
    impatient = Database(settings.sqlalchemy_url)
    with closing(impatient), ThreadPoolExecutor(1) as thread:
        with sqlite.write() as db:
            db.add(Account(name="Bob"))
            db.flush()
            graded = thread.submit(worker_of(impatient, settings).run_one)
            deadline = time.monotonic() + 300
            while "the database is locked" not in caplog.text and time.monotonic() < deadline:
                time.sleep(0.01)
        assert graded.result()
    assert "the database is locked" in caplog.text
    assert only(sqlite, Grading).outcome == Outcome.OK


def test_the_heartbeat_extends_the_lease_while_grading(sqlite: Database, settings: Settings) -> None:
    beating = settings.model_copy(update={"lease_seconds": 0.15})
    account = Account(name="Ada")
    with sqlite.write() as db:
        db.add(account)
    submitted(sqlite, settings, account)
    untils: list[Any] = []

    def slow(sent: GradingInput) -> Judgement:
        first = only(sqlite, Job).lease_until
        deadline = time.monotonic() + 300
        while only(sqlite, Job).lease_until == first and time.monotonic() < deadline:
            time.sleep(0.01)
        untils.extend([first, only(sqlite, Job).lease_until])
        return fake_grade(sent)

    class Once:
        buffers_wakeups = True

        def wait(self, seconds: float) -> bool:
            return False

    worker_of(sqlite, beating, slow).run(Once())
    assert untils[1] > untils[0]
    assert none(sqlite, Job)


@pytest.mark.parametrize(("buffers_wakeups", "asked_again"), [(True, 0), (False, 1)])
def test_only_who_is_owed_its_wake_ups_does_not_ask_after_a_job_that_nothing_followed(
    sqlite: Database, settings: Settings, buffers_wakeups: bool, asked_again: int
) -> None:
    account = Account(name="Ada")
    with sqlite.write() as db:
        db.add(account)
    for _ in range(3):
        submitted(sqlite, settings, account)

    class Once:
        def __init__(self) -> None:
            self.buffers_wakeups = buffers_wakeups

        def wait(self, seconds: float) -> bool:
            return False

    with Counted(sqlite) as counted:
        worker_of(sqlite, settings).run(Once())
    claims = [statement for statement in counted.statements if statement.startswith("UPDATE job SET")]
    assert len(claims) == 3 + asked_again
    assert none(sqlite, Job)


@pytest.fixture
def grader(course: Course, course_sandbox: Sandbox) -> SandboxGrader:
    return SandboxGrader(course, course_sandbox)


def test_the_reference_gets_full_marks_through_the_sandbox(grader: SandboxGrader, course: Course) -> None:
    exercise = course.exercises[EXERCISE]
    verdict = grader.grade(EXERCISE, exercise.solution.encode(), seed=7).verdict
    assert (verdict.outcome, verdict.score, verdict.seed) == (Outcome.OK, 1.0, 7)
    assert verdict.exercise_version == exercise.version


def test_the_same_seed_gives_the_same_verdict(grader: SandboxGrader, course: Course) -> None:
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
    grader: SandboxGrader, source: bytes, outcome: Outcome, told: str
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
    failures: int, outcome: Outcome, course_sandbox: Sandbox, course: Course, caplog: pytest.LogCaptureFixture
) -> None:
    failing = Failing(course_sandbox, failures)
    source = course.exercises[EXERCISE].solution.encode()
    with caplog.at_level(logging.ERROR):
        one = uuid4()
        result = SandboxGrader(course, failing).grade(EXERCISE, source, 123, submission=one)  # type: ignore[arg-type]
    assert result.verdict.outcome is outcome
    assert len(caplog.records) == min(failures, grading.TRIES)
    version, digest = course.exercises[EXERCISE].version, hashlib.sha256(source).hexdigest()
    for told in ("the template is dead", "Traceback", EXERCISE, version, "seed 123", str(one), digest):
        assert told in caplog.text


def asleep_when_told_to_stop() -> None:
    threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGTERM)).start()
    time.sleep(60)


def test_sigterm_stops_a_worker_in_its_main_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    from server.grading import worker_process

    monkeypatch.setattr(worker_process, "_graceful_stop", GracefulStop())  # others of this process are not told
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}
    try:
        worker_process.stop_on_signals()
        with pytest.raises(StopRequested):
            asleep_when_told_to_stop()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_a_job_that_does_not_end_is_given_up_at_once_with_its_worker(
    sqlite: Database, settings: Settings, course: Course, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would take as long again, and a third time."""

    class Ended(Exception):
        pass

    def end(status: int) -> None:
        raise Ended(status)

    monkeypatch.setattr("server.queue.job_runner.os._exit", end)
    submitted(sqlite, settings, new_account(sqlite))
    owner = process_owner(os.getpid())
    with sqlite.write() as db:
        lease = QUIET.claim(db, owner, [GRADE], 60)
    assert lease is not None
    with pytest.raises(Ended):
        LeaseHeartbeat(sqlite, QUIET, settings, give_up_handlers(course))._extend_lease(lease, time.monotonic() - 1)
    assert none(sqlite, Job)
    assert only(sqlite, Grading).outcome == Outcome.INTERNAL_ERROR


def test_a_locked_database_is_left_alone_for_longer_each_time() -> None:
    assert [*itertools.islice(_backoff(), 8)] == [0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0, 10.0]


def test_what_exhausts_the_judge_is_the_student_s_outcome(course_sandbox: Sandbox, course: Course) -> None:
    """A budget spent before the first answer stands for one that comparing has spent."""
    exercise = course.exercises[EXERCISE]
    programs = SandboxPrograms(course_sandbox, replace(exercise.policy, judging_seconds=1e-9))
    verdict = exercise.grader.grade(exercise.solution.encode(), programs, seed=7, version="v").verdict
    assert verdict.outcome is Outcome.OUTPUT_LIMIT
    assert verdict.outcome.counts
    assert all("a pris plus de" in check.message for check in verdict.checks)


def test_a_judge_s_patience_may_end_between_two_answers(
    course_sandbox: Sandbox, course: Course, monkeypatch: pytest.MonkeyPatch
) -> None:
    exercise = course.exercises[EXERCISE]
    program = SandboxPrograms(course_sandbox, exercise.policy).open(exercise.solution.encode(), KitSettings("l20", {}))
    with closing(program):
        spent = iter([None, None, StudentFault(Outcome.OUTPUT_LIMIT, "assez", fatal=True)])
        monkeypatch.setattr(program._budget, "fault_if_exhausted", lambda: next(spent))
        answers = list(program.call_many("inverse", [(np.zeros(3),)] * 9))
    assert [type(answer) for answer in answers] == [Reply, Reply, StudentFault]


def test_the_processor_time_of_a_program_is_counted_once_it_is_closed_and_once(
    course_sandbox: Sandbox, course: Course
) -> None:
    exercise = course.exercises[EXERCISE]
    programs = SandboxPrograms(course_sandbox, exercise.policy)
    program = programs.open(exercise.solution.encode(), KitSettings("l20", {}))
    program.call("inverse", np.zeros(3))
    assert programs.ended_cpu_seconds() == 0.0
    program.close()
    spent = programs.ended_cpu_seconds()
    assert spent > 0.0
    program.close()
    assert programs.ended_cpu_seconds() == spent == programs.cpu_seconds


def test_a_file_that_loops_everywhere_takes_its_whole_time_once_and_a_right_function_keeps_its_points(
    course_sandbox: Sandbox, course: Course
) -> None:
    exercise = course.exercises["l20/odometrie"]
    policy = replace(exercise.policy, cpu_seconds=0.5, wall_seconds=60.0)
    first, *others = [function.name for function in exercise.functions]
    source = f"{exercise.solution}\n\ndef {first}(*_arguments):\n    while True:\n        pass\n"
    verdict = SandboxGrader(course, course_sandbox).grade(exercise.id, source.encode(), 1, policy=policy).verdict
    assert verdict.outcome is Outcome.TIMEOUT
    assert 0 < verdict.score < 1
    assert grading.TIMED_OUT in verdict.remarks
    assert others
