"""The engine between machines, with a real NATS server and a real PostgreSQL.

Workers look into the database every thirty seconds here: whatever is done sooner was told by a ticket.
"""

from __future__ import annotations

import asyncio
import re
import threading
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from uuid import uuid4

import pytest
from sqlalchemy import select

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from server.base.files import ROOT
from server.base.settings import Settings
from server.course import Course
from server.gradebook.models import Grading
from server.grading.grading_task import GradingInput, give_up_handlers
from server.grading.job_lanes import JOB_LANES
from server.queue.graceful_stop import StopRequested
from server.queue.interfaces import (
    BACKGROUND,
    INTERACTIVE,
    JOB_STARTED_SUFFIX,
    JobNotification,
    NullNotifier,
    Sender,
    WorkerCapabilities,
)
from server.queue.jetstream.credentials import TlsEnforcingClient
from server.queue.jetstream.stream_layout import STREAM, build_layout
from server.queue.jetstream.sweeper import LostMessageSweeper
from server.queue.lease_owner import process_owner
from server.queue.models import Job
from server.queue.service import TableQueue
from server.submissions.models import Submission, SubmissionState
from server.submissions.service import (
    GRADE,
    OUTDATED_NOTICE,
    GradingProgress,
    SubmissionService,
    job_key,
    worker_version_requirement,
)
from tests.support.cluster import PATIENCE, Baker, Hand, Machine, Nats, until
from tests.support.service import ADDRESS, EXERCISE, fake_grade, new_account

LEASE = 0.6


class Service:
    """Web processes and workers of one service, made as they are asked for."""

    def __init__(self, settings: Settings, made: list[Machine]) -> None:
        self.settings, self._made = settings, made
        self.web = self.machine()
        self.account = new_account(self.web.database)

    def machine(self, **settings: float) -> Machine:
        one = Machine(self.settings.model_copy(update=settings)).start().up()
        self._made.append(one)
        return one

    def hand(self, grade: object = fake_grade, able: WorkerCapabilities | None = None) -> Hand:
        return Hand(self.machine(), grade, able).start()  # type: ignore[arg-type]

    def submit(self, version: str | None = None) -> str:
        store = SubmissionService(self.settings, self.web.queue, needed_version=lambda _: version)
        with self.web.database.write() as db:
            return job_key(store.submit(db, self.account, EXERCISE, "pass", address=ADDRESS).id)

    def gradings(self) -> Sequence[Grading]:
        with self.web.database.read() as db:
            return list(db.execute(select(Grading)).scalars())

    def graded(self) -> list[str]:
        return sorted(str(one.submission_id) for one in self.gradings())

    def jobs(self) -> Sequence[Job]:
        with self.web.database.read() as db:
            return list(db.execute(select(Job)).scalars())

    def job(self) -> Job:
        (job,) = self.jobs()
        return job

    def place(self) -> GradingProgress:
        with self.web.database.read() as db:
            return SubmissionService(self.settings, self.web.queue).progress(
                db, db.execute(select(Submission)).scalar_one()
            )

    def tickets(self, of: Machine | None = None) -> int:
        """How many the stream holds."""
        connection = (of or self.web).engine.connection
        return connection.run_blocking(lambda: connection.jetstream.stream_info(STREAM), PATIENCE).state.messages

    def sweep(self) -> int:
        with self.web.database.read() as db:
            return self.web.engine.sweeper.resend_missing(db)

    def taken_and_dropped(self, course: Course) -> None:
        """A worker of another machine takes a ticket and a job, and is heard of no more."""
        dead = self.machine()
        tickets = dead.engine.subscribe()
        owner, lease = replace(process_owner(1), host="elsewhere"), None
        while lease is None:
            tickets.wait(PATIENCE)
            ticket = tickets.take_message()
            if ticket is None:
                continue
            with dead.database.write() as db:
                if ticket.redelivered:
                    dead.queue.recover_lost(db, owner, give_up_handlers(course))
                lease = dead.queue.claim(db, owner, [GRADE], self.settings.lease_seconds)
            if lease is None:
                ticket.ack(job_done=False)
            else:
                ticket.in_progress()
        dead.close()


@pytest.fixture
def service(shared_settings: Settings, machines: list[Machine]) -> Service:
    return Service(shared_settings, machines)


@pytest.fixture
def hasty(shared_settings: Settings, machines: list[Machine]) -> Service:
    """Leases are short."""
    return Service(shared_settings.model_copy(update={"lease_seconds": LEASE}), machines)


def test_submission_to_one_web_process_is_graded_elsewhere_and_shown_by_another(service: Service) -> None:
    hand, other = service.hand(), service.machine()
    sent = sorted(service.submit() for _ in range(3))
    until(lambda: service.graded() == sent, "all are graded")
    news = sorted(told for key in sent for told in (key, key + JOB_STARTED_SUFFIX))
    until(lambda: sorted(other.told) == news, "the other is told that each began and ended")
    hand.stop()
    assert not service.jobs()
    assert service.web.engine.status() == "ok"


def test_job_of_a_dead_worker_is_redelivered_and_graded_once(hasty: Service, course: Course) -> None:
    sent = hasty.submit()
    hasty.taken_and_dropped(course)
    assert hasty.job().tries == 1
    hand = hasty.hand()
    until(lambda: hasty.graded() == [sent], "another grades it")
    hand.stop()
    assert not hasty.jobs()


def test_a_job_that_ends_its_workers_is_given_up_as_our_error(hasty: Service, course: Course) -> None:
    hasty.submit()
    for _ in range(3):
        hasty.taken_and_dropped(course)
    hand = hasty.hand()
    until(lambda: bool(hasty.gradings()), "it is given up")
    hand.stop()
    assert [one.outcome for one in hasty.gradings()] == [Outcome.INTERNAL_ERROR]


def test_a_frozen_worker_that_comes_back_writes_nothing(hasty: Service, caplog: pytest.LogCaptureFixture) -> None:
    begun, woken = threading.Event(), threading.Event()

    def freezing(sent: GradingInput) -> Judgement:
        begun.set()
        woken.wait(PATIENCE)
        return fake_grade(replace(sent, source=b"outcome: wrong_answer"))

    frozen = hasty.hand(freezing)
    frozen.worker._runner.heartbeat._extend_lease = lambda *_: None  # type: ignore[method-assign]
    sent = hasty.submit()
    assert begun.wait(PATIENCE)
    hand = hasty.hand()
    until(lambda: hasty.graded() == [sent], "another grades it")
    woken.set()
    until(lambda: "the lease was lost" in caplog.text, "the first one's result is refused")
    frozen.stop()
    hand.stop()
    assert [one.outcome for one in hasty.gradings()] == [Outcome.OK]


def test_a_worker_that_works_for_long_keeps_its_ticket(hasty: Service) -> None:
    def slow(sent: GradingInput) -> Judgement:
        time.sleep(3 * LEASE)
        return fake_grade(sent)

    hands = [hasty.hand(slow), hasty.hand(slow)]
    hasty.submit()
    until(lambda: bool(hasty.jobs()) and hasty.job().tries == 1, "it is begun")
    until(lambda: bool(hasty.gradings()), "it is graded")
    for hand in hands:
        hand.stop()
    assert len(hasty.gradings()) == 1
    assert hasty.sweep() == 0


def test_stopped_worker_hands_its_job_back_at_once(service: Service) -> None:
    def stopped(_sent: GradingInput) -> Judgement:
        raise StopRequested

    sent = service.submit()
    leaving = service.hand(stopped)
    until(lambda: not leaving._thread.is_alive(), "it has left")
    assert (service.job().tries, service.job().lease_token) == (0, None)
    leaving.tickets.close()
    hand = service.hand()
    until(lambda: service.graded() == [sent], "another grades it, long before a lease ends")
    hand.stop()


@pytest.mark.parametrize("emptied", ["purge_stream", "delete_stream"])
def test_sweeper_resends_messages_that_the_stream_has_lost(service: Service, emptied: str) -> None:
    sent = sorted(service.submit() for _ in range(3))
    connection = service.web.engine.connection

    until(lambda: service.tickets() == 3, "each has its ticket")
    assert service.sweep() == 0
    connection.run_blocking(lambda: getattr(connection.jetstream, emptied)(STREAM), PATIENCE)
    assert [service.sweep(), service.sweep()] == [0, 3], "it takes two looks: what is on its way is not missing"
    hand = service.hand()
    until(lambda: service.graded() == sent, "all are graded")
    hand.stop()


def test_several_sweepers_call_once(service: Service) -> None:
    """For three jobs of which nobody was told, as after a restoration."""
    machines = [service.web, service.machine(), service.machine()]
    with service.web.database.write() as db:
        for number in range(3):
            TableQueue(NullNotifier()).enqueue(db, GRADE, str(number))
    sweepers = [LostMessageSweeper(one.engine.connection, lambda: 1000.0) for one in machines]
    with service.web.database.read() as db:
        assert [one.resend_missing(db) for one in sweepers] == [0, 0, 0], "what is on its way is not missing"
        called = [one._resend(db, GRADE, 3) for one in sweepers]  # as when they look at the same moment
    assert called == [3, 3, 3]
    for machine in machines[1:]:
        machine.close()  # what is being posted ends first
    until(lambda: service.tickets() >= 3 and not service.web.engine.connection._sending, "the calls are there")
    assert service.tickets() == 3, "each job has one, whoever called"


def test_autoscaler_reads_an_existing_consumer(settings: Settings) -> None:
    told = (ROOT / "server" / "deploy" / "kubernetes" / "scaling.yaml").read_text(encoding="utf-8")
    assert f"stream: {STREAM}\n" in told
    (consumer,) = re.findall(r"consumer: (\S+)", told)
    assert consumer == build_layout(settings, JOB_LANES).consumer_of_kind(GRADE).consumer_name


def test_a_ticket_holds_a_name_and_no_more(settings: Settings) -> None:
    """Whoever may publish there fills no disk: a million names at most."""
    stream = build_layout(settings, JOB_LANES).stream_config()
    header = f"NATS/1.0\r\nNats-Msg-Id: {uuid4()}:again:{10**12}\r\n\r\n"
    assert len(header) < (stream.max_msg_size or 0) <= 4096
    plain = stream.evolve(max_msg_size=-1)
    assert build_layout(settings, JOB_LANES)._stream_differs(plain), "a stream made before is put right"


@pytest.fixture
def own_nats(tmp_path: Path) -> Iterator[Nats]:
    server = Nats(tmp_path / "nats")
    server.start()
    yield server
    server.stop()


def test_without_nats_nothing_is_lost_nor_stands_still_and_it_is_told(
    shared_settings: Settings, machines: list[Machine], own_nats: Nats
) -> None:
    settings = shared_settings.model_copy(update={"nats_url": own_nats.url, "poll_seconds": 0.05})
    service = Service(settings, [])
    own_nats.stop()
    until(lambda: service.web.engine.status() == "unreachable", "it is noticed")
    sent = [service.submit()]
    worker = Machine(settings).start()  # it starts without NATS too
    hand = Hand(worker).start()
    until(lambda: service.graded() == sent, "it is found in the database")
    hand.stop()
    worker.close()
    sent.append(service.submit())
    assert service.sweep() == 0
    own_nats.start()
    service.web.up()
    assert [service.sweep(), service.sweep()] == [0, 1]
    assert service.web.engine.status() == "ok"
    hand = Hand(Machine(settings.model_copy(update={"poll_seconds": 30.0})).start().up()).start()
    until(lambda: service.graded() == sorted(sent), "it is called for again")
    hand.stop()
    hand.machine.close()
    service.web.close()


def test_turns_hold_and_what_somebody_waits_for_goes_first(shared_settings: Settings, machines: list[Machine]) -> None:
    """The same orders on SQLite's queue and through tickets: theirs is not the order of the calls."""
    lanes = {"wash": BACKGROUND, "bake": INTERACTIVE}
    greedy, late = Sender("a", flow="a"), Sender("b", flow="b")
    put = [("wash", "w1", Sender(rank=9)), *(("bake", f"a{n}", greedy) for n in range(4))]
    put += [("bake", "b0", late), ("bake", "b1", late), ("bake", "guest", Sender("g", flow="g", rank=2))]
    put += [("bake", "member", Sender("m", flow="m", rank=-1)), ("wash", "w2", Sender(rank=9))]
    machine = Machine(shared_settings, lanes).start().up()
    machines.append(machine)
    for kind, key, sender in put:
        with machine.database.write() as db:
            machine.queue.enqueue(db, kind, key, sender=sender)
    baker = Baker(machine, lanes)
    baker.start()
    until(lambda: len(baker.done) == len(put), "all is done")
    baker.stop()
    assert baker.done == ["member", "a0", "b0", "a1", "b1", "a2", "a3", "guest", "w1", "w2"]


def test_a_worker_of_another_version_leaves_it_to_the_right_one(service: Service) -> None:
    old, new = (WorkerCapabilities([worker_version_requirement(EXERCISE, version)], 3600.0) for version in ("v1", "v2"))
    before = service.hand(able=old)
    service.submit("v2")
    until(lambda: service.job().refused_at is not None, "it is refused")
    place = service.place()
    assert (place.state, place.notice) == (SubmissionState.queued, OUTDATED_NOTICE)
    assert (service.job().tries, service.graded()) == (0, [])
    after = service.hand(able=new)
    until(lambda: bool(service.graded()), "the right one grades it")
    before.stop()
    after.stop()


def test_job_refused_for_too_long_is_claimed_by_any_worker(service: Service) -> None:
    service.submit("v0")
    hand = service.hand(able=WorkerCapabilities([worker_version_requirement(EXERCISE, "v1")], 0.3))
    until(lambda: bool(service.graded()), "it is graded after all")
    hand.stop()
    assert not service.jobs()


def test_a_worker_to_whom_nothing_is_brought_looks_by_itself_now_and_then(service: Service) -> None:
    """Whatever a stream says of its tickets after a fault, nothing waits for ever. Nobody sweeps here."""
    machine = service.machine(poll_seconds=0.01)
    hand = Hand(machine).start()
    until(lambda: hand.tickets._jetstream_answers, "it waits for tickets")
    store = SubmissionService(service.settings, TableQueue(NullNotifier()))
    with service.web.database.write() as db:
        sent = job_key(store.submit(db, service.account, EXERCISE, "pass", address=ADDRESS).id)
    until(lambda: service.graded() == [sent], "it is found")
    hand.stop()


def test_a_connection_that_meets_something_unheard_of_is_made_again(
    service: Service, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As half a message, from a server that dies: nothing else would ever connect this process again."""
    machine, real = service.machine(), TlsEnforcingClient.connect
    refusals: list[Exception] = [ValueError("half a message")]

    async def connect(client: TlsEnforcingClient, **options: object) -> None:
        if refusals:
            raise refusals.pop()
        await real(client, **options)

    monkeypatch.setattr(TlsEnforcingClient, "connect", connect)
    connection = machine.engine.connection
    connection.call_on_loop(lambda: asyncio.ensure_future(connection.connected_client.close()))
    until(lambda: not refusals and connection.is_up, "it is up again")
    machine.engine.connection.run_blocking(connection.connected_client.flush, PATIENCE)


def test_a_ticket_too_many_finds_no_job_and_goes(service: Service) -> None:
    for _ in range(3):
        service.web.engine.connection.publish_job_available(JobNotification(GRADE, str(uuid4())))
    hand = service.hand()
    until(lambda: service.tickets() == 0, "they are gone")
    sent = service.submit()
    until(lambda: service.graded() == [sent], "a real one is used")
    hand.stop()
