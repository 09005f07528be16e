"""A real NATS server with JetStream, and one machine's part of a service that several share."""

from __future__ import annotations

import os
import random
import shutil
import signal
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self

import pytest
from sqlalchemy.orm import Session

from server.base.settings import Settings
from server.database import Database
from server.grading.grading_task import GradeFunction, GradingTask
from server.grading.job_lanes import JOB_LANES
from server.queue.graceful_stop import GracefulStop, StopRequested
from server.queue.interfaces import Lease, Tasks, WorkerCapabilities
from server.queue.jetstream.engine import NatsEngine
from server.queue.service import TableQueue
from server.queue.worker import Worker
from server.submissions.service import GRADE
from tests.support.quick import the_course
from tests.support.service import fake_grade, opened
from tests.support.shared import shared

ACCOUNTS = 16
CONFIG = """
listen: "127.0.0.1:{port}"
jetstream {{ store_dir: "{folder}" }}
accounts {{
{accounts}
}}
{more}
"""
PATIENCE = 300.0  # seconds, against hanging alone: each wait ends by what it waits for


#: Below those of connections: what is stopped finds its port free when it comes back.
PORTS = range(20_000, 32_000)


def free_port() -> int:
    while True:
        port = random.choice(PORTS)
        with socket.socket() as found, suppress(OSError):
            found.bind(("127.0.0.1", port))
            return port


class Nats:
    """One `nats-server`, which keeps its port and its store when it is started again."""

    def __init__(self, folder: Path, more: str = "", accounts: str | None = None) -> None:
        self.port, self._folder = free_port(), folder
        folder.mkdir(parents=True, exist_ok=True)
        each = "\n".join(
            f'  T{n}: {{ jetstream: enabled, users: [{{user: "t{n}", password: "t{n}"}}] }}' for n in range(ACCOUNTS)
        )
        self.config = folder / "nats.conf"
        text = CONFIG.format(
            port=self.port, folder=folder / "store", accounts=each if accounts is None else accounts, more=more
        )
        self.config.write_text(text)
        self.process: subprocess.Popen[bytes] | None = None

    @property
    def url(self) -> str:
        return f"nats://t0:t0@127.0.0.1:{self.port}"

    def start(self) -> None:
        log = (self._folder / "nats.log").open("ab")
        self.process = subprocess.Popen([nats_server(), "-c", str(self.config)], stdout=log, stderr=log)
        log.close()
        deadline = time.monotonic() + PATIENCE
        while not self._listens():
            assert self.process.poll() is None, (self._folder / "nats.log").read_text()
            assert time.monotonic() < deadline
            time.sleep(0.02)

    def _listens(self) -> bool:
        with socket.socket() as asked:
            return asked.connect_ex(("127.0.0.1", self.port)) == 0

    def stop(self, number: int = signal.SIGKILL) -> None:
        if self.process is not None:
            self.process.send_signal(number)
            self.process.wait(PATIENCE)
            self.process = None


def nats_server() -> str:
    found = shutil.which("nats-server", path=f"{os.defpath}:/usr/sbin:/usr/local/sbin:/usr/local/bin")
    if found is None:
        pytest.skip("no NATS: Debian's package nats-server is not installed")
    return found


@contextmanager
def _started(folder: Path) -> Iterator[str]:
    server = Nats(folder)
    server.start()
    yield f"127.0.0.1:{server.port}"
    server.stop(signal.SIGTERM)


@pytest.fixture(scope="session")
def nats_address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Of one NATS server for all test processes."""
    nats_server()
    with shared(tmp_path_factory, "nats", _started) as address:
        yield address


@pytest.fixture(scope="session")
def nats_url(nats_address: str, worker_id: str) -> str:
    """An account of this test process alone: it sees no other's stream."""
    number = 0 if worker_id == "master" else int(worker_id.removeprefix("gw")) % ACCOUNTS
    return f"nats://t{number}:t{number}@{nats_address}"


class Machine:
    """A process's part: its own pool of connections to the database, its own connection to NATS, what it was told."""

    def __init__(self, settings: Settings, lanes: Mapping[str, str] = JOB_LANES) -> None:
        self.settings, self.told = settings, list[str]()
        self.engine = NatsEngine(settings, lanes, self.told.append)
        self.database = Database(settings.sqlalchemy_url)
        self.queue = TableQueue(self.engine.notifier)

    def start(self) -> Machine:
        self.engine.connection.start()
        return self

    def up(self) -> Machine:
        connection = self.engine.connection
        until(lambda: connection.is_up and connection.wait_ready(PATIENCE), "NATS answers")
        return self

    def close(self) -> None:
        self.engine.connection.close()
        self.database.close()


@pytest.fixture
def shared_settings(settings: Settings, postgres_url: str, nats_url: str) -> Iterator[Settings]:
    """Of machines that share a database and a NATS server; a new stream."""
    both = settings.model_copy(update={"database_url": postgres_url, "nats_url": nats_url, "poll_seconds": 30.0})
    for _ in opened(both):
        yield both


@pytest.fixture
def machines(shared_settings: Settings) -> Iterator[list[Machine]]:
    """What is made through `joined` is closed, and the stream goes."""
    made: list[Machine] = []
    yield made
    for one in made:
        one.close()
    last = Machine(shared_settings).start().up()
    last.engine.connection.run_blocking(lambda: last.engine.connection.jetstream.delete_stream("work"), 5.0)
    last.close()


class Thread:
    """A worker in a thread, on a machine."""

    def __init__(self, machine: Machine, tasks: Tasks, able: WorkerCapabilities | None = None) -> None:
        self.machine, self.stopping = machine, GracefulStop()
        self.tickets = machine.engine.subscribe()
        args = (machine.database, machine.queue, machine.settings, tasks)
        self.worker = Worker(*args, capabilities=able, graceful_stop=self.stopping)
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> Self:
        self._thread.start()
        return self

    def _run(self) -> None:
        with suppress(StopRequested):
            self.worker.run_on_messages(self.tickets)

    def stop(self) -> None:
        self.stopping.requested.set()
        self.tickets._arrived.set()
        self._thread.join(PATIENCE)
        assert not self._thread.is_alive()
        self.tickets.close()


class Hand(Thread):
    """A grader; `grade` is what it does."""

    def __init__(
        self, machine: Machine, grade: GradeFunction = fake_grade, able: WorkerCapabilities | None = None
    ) -> None:
        super().__init__(machine, {GRADE: GradingTask(the_course(), grade)}, able)


class Baker(Thread):
    """Does jobs of any kinds, and notes their keys."""

    def __init__(self, machine: Machine, kinds: Iterable[str]) -> None:
        self.done: list[str] = []
        super().__init__(machine, dict.fromkeys(kinds, self))  # type: ignore[arg-type]

    def read(self, _db: Session, lease: Lease) -> str:
        return lease.key

    def run(self, work: str) -> str:
        return work

    def record(self, _db: Session, _work: str, result: str) -> None:
        self.done.append(result)

    def give_up(self, _db: Session, lease: Lease) -> None:
        raise AssertionError(lease)


def until(condition: Callable[[], bool], what: str, seconds: float = PATIENCE) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"still not: {what}"
        time.sleep(0.01)
