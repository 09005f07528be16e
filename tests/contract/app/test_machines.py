"""Several machines that share PostgreSQL and NATS: two web processes, workers that belong to neither, and what befalls
them all."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import select, text

from server.app import ApplicationServices
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from server.queue.jetstream.connection import NatsUnavailableError
from server.submissions import job_events as events_module
from server.submissions.models import Submission, SubmissionState
from server.submissions.service import GradingProgress, SubmissionService, job_key
from tests.support.cluster import PATIENCE, Hand, Machine, Nats, free_port, until
from tests.support.live import Live, children, environment
from tests.support.quick import in_a_loop
from tests.support.service import ADDRESS, EXERCISE, fake_grade, new_account


class Seen:
    """A submission as one web process tells of it."""

    def __init__(self, place: GradingProgress) -> None:
        self.done, self.state = place.state is SubmissionState.done, place.state

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Seen) and other.state == self.state

    __hash__ = None  # type: ignore[assignment]


def test_each_web_process_tells_of_what_was_sent_to_the_other(
    shared_settings: Settings, machines: list[Machine], course: Course, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(events_module, "SAFETY_POLL", 3600.0)
    worker = Machine(shared_settings)
    machines.append(worker)

    async def story() -> list[SubmissionState]:
        one, other = (ApplicationServices(shared_settings, course, ()) for _ in range(2))
        async with AsyncExitStack() as stack:
            for services in (one, other):
                await stack.enter_async_context(services.run_during_lifespan())
                assert services.nats_engine is not None
                assert await asyncio.to_thread(services.nats_engine.connection.wait_ready, PATIENCE)
            key = await asyncio.to_thread(send, one)

            def read() -> Seen:
                with other.database.read() as db:
                    return Seen(other.submissions.progress(db, db.execute(select(Submission)).scalar_one()))

            states = []
            async for seen in other.job_events.follow(key, read):
                states.append(seen.state)
                if len(states) == 1:
                    hand = Hand(worker.start().up()).start()
            await asyncio.to_thread(hand.stop)
        for services in (one, other):
            services.database.close()
        return states

    states = in_a_loop(asyncio.wait_for(story(), 2 * PATIENCE))
    assert (states[0], states[-1]) == (SubmissionState.queued, SubmissionState.done)


def send(services: ApplicationServices) -> str:
    account = new_account(services.database)
    with services.database.write() as db:
        return job_key(services.submissions.submit(db, account, EXERCISE, "pass", address=ADDRESS).id)


GRADED_TWICE = "SELECT submission_id FROM grading GROUP BY submission_id HAVING count(*) > 1"


class Park:
    """Two servers without workers of their own, and workers that are started by name."""

    def __init__(self, folder: Path, settings: Settings, nats: Nats, code: str) -> None:
        self._folder, self._code, self.nats = folder, code, nats
        self.database = Database(settings.sqlalchemy_url)
        self.values = {
            "BALISE_DATABASE_URL": str(settings.database_url),
            "BALISE_NATS_URL": nats.url,
            "BALISE_WORKERS": "0",
            "BALISE_LEASE_SECONDS": "3",
            "BALISE_SUBMISSION_BURST": "1000",
        }
        self.one = Live(folder / "one" / "data", **self.values)
        self.other = Live(folder / "other" / "data", **self.values)
        self.other.sign_up_teacher()  # the link of the server that started last
        self.headers = {"Authorization": f"Bearer {self.other.token()}"}
        self.sent: list[str] = []
        self.workers: list[subprocess.Popen[bytes]] = []

    def worker(self) -> subprocess.Popen[bytes]:
        with self.log.open("ab") as log:
            values = environment(**self.values)
            command = [sys.executable, "-m", "server", "worker"]
            started = subprocess.Popen(command, stdout=log, stderr=log, env=values)
        self.workers.append(started)
        return started

    @property
    def log(self) -> Path:
        return self._folder / "workers.log"

    def submit(self, seconds: float) -> str:
        code = f"import time\ntime.sleep({seconds})\n{self._code}"
        body = {"exercise": EXERCISE, "code": code}
        answer = self.one.client.post("/api/v1/submissions", json=body, headers=self.headers)
        assert answer.status_code == 202, answer.text
        self.sent.append(answer.json()["id"])
        return self.sent[-1]

    def rows(self, query: str) -> list[Any]:
        with self.database.read() as db:
            return list(db.execute(text(query)).all())

    def holder(self) -> int:
        """The process that has begun a job, once there is one."""
        until(lambda: bool(self.rows("SELECT 1 FROM job WHERE lease_token IS NOT NULL")), "one is begun")
        ((owner,),) = self.rows("SELECT lease_owner FROM job WHERE lease_token IS NOT NULL LIMIT 1")
        return int(owner.split("|")[3])

    def drained(self) -> None:
        until(lambda: not self.rows("SELECT 1 FROM submission WHERE grading_id IS NULL"), "all are graded")

    def close(self) -> None:
        for process in [*self.workers, self.one.process, self.other.process]:
            if process.poll() is None:
                process.kill()
                process.wait()
        self.database.close()


@pytest.fixture
def park(tmp_path: Path, shared_settings: Settings, course: Course) -> Iterator[Park]:
    nats = Nats(tmp_path / "nats")
    nats.start()
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
    one = Park(tmp_path, shared_settings, nats, course.exercises[EXERCISE].solution)
    yield one
    one.close()
    nats.stop()


@pytest.mark.slow
def test_real_processes_are_killed_frozen_stopped_and_left_without_nats(park: Park) -> None:
    the_other_server_follows_what_one_was_sent(park)
    a_killed_worker_s_job_is_another_s(park)
    a_frozen_worker_writes_nothing(park)
    a_stopped_worker_gives_its_job_back(park)
    without_nats_it_goes_on(park)
    park.drained()
    graded = Counter(str(one) for (one,) in park.rows("SELECT submission_id FROM grading"))
    assert graded == Counter(park.sent), "each is graded exactly once"
    assert park.rows("SELECT DISTINCT outcome FROM grading") == [("ok",)]
    below = [pid for live in (park.one, park.other) for pid in children(live.process.pid)]
    for process in [*park.workers, park.one.process, park.other.process]:
        if process.poll() is None:
            process.terminate()
            assert process.wait(300) == 0
    until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in below), "nothing is left running")


def the_other_server_follows_what_one_was_sent(park: Park) -> None:
    park.worker()
    sent = park.submit(0.3)
    url = f"/api/v1/submissions/{sent}/events"
    with park.other.client.stream("GET", url, headers=park.headers) as answer:
        told = "".join(answer.iter_lines())
    assert re.search(r'"status": "done"', told), told


def a_killed_worker_s_job_is_another_s(park: Park) -> None:
    park.submit(1.0)
    holder = park.holder()
    park.worker()
    os.kill(holder, signal.SIGKILL)
    park.drained()


def a_frozen_worker_writes_nothing(park: Park) -> None:
    park.submit(1.0)
    holder = park.holder()
    os.kill(holder, signal.SIGSTOP)
    park.worker()
    park.drained()
    os.kill(holder, signal.SIGCONT)
    until(lambda: "the lease was lost" in park.log.read_text(), "its verdict is refused")


def a_stopped_worker_gives_its_job_back(park: Park) -> None:
    """A lease that ended would count as a try."""
    park.submit(2.0)
    holder = park.holder()
    leaving = next(one for one in park.workers if one.pid == holder)
    leaving.terminate()
    assert leaving.wait(300) == 0
    assert park.rows("SELECT tries FROM job WHERE tries > 1") == []
    until(lambda: park.holder() != holder, "another has begun it")
    assert park.rows("SELECT tries FROM job") == [(1,)]
    park.drained()


def without_nats_it_goes_on(park: Park) -> None:
    park.nats.stop()

    def ready() -> tuple[int, str]:
        answer = park.one.client.get("/readyz")
        return answer.status_code, answer.json()["status"]

    until(lambda: ready() == (200, "degraded"), "it is told")
    park.submit(0.0)
    park.drained()
    park.nats.start()
    until(lambda: ready() == (200, "ok"), "it is back")
    park.submit(0.0)
    park.drained()


@pytest.fixture
def three_nodes(tmp_path: Path) -> Iterator[list[Nats]]:
    routes = [free_port() for _ in range(3)]
    told = ", ".join(f'"nats://127.0.0.1:{port}"' for port in routes)
    nodes = [
        Nats(
            tmp_path / f"node{n}",
            f'server_name: n{n}\ncluster {{ name: c, listen: "127.0.0.1:{port}", routes: [{told}] }}',
        )
        for n, port in enumerate(routes)
    ]
    for node in nodes:
        node.start()
    yield nodes
    for node in nodes:
        node.stop()


@pytest.mark.slow
def test_a_cluster_of_three_outlives_each_of_its_nodes(shared_settings: Settings, three_nodes: list[Nats]) -> None:
    url = ",".join(node.url for node in three_nodes)
    settings = shared_settings.model_copy(update={"nats_url": url, "nats_replicas": 3, "submission_burst": 1000})
    web, worker = Machine(settings).start(), Machine(settings).start()
    for machine in (web, worker):
        assert machine.engine.connection.wait_ready(3 * PATIENCE), "the three have elected a leader"
    account, sent = new_account(web.database), list[str]()
    store = SubmissionService(settings, web.queue)

    def submit() -> None:
        with web.database.write() as db:
            sent.append(job_key(store.submit(db, account, EXERCISE, "pass", address=ADDRESS).id))

    def swept() -> bool:
        """Whether all are graded; else a server looks, as it does every three seconds, whether tickets are missing."""
        if graded(web) == sorted(sent):
            return True
        with web.database.read() as db:
            web.engine.sweeper.resend_missing(db)
        time.sleep(0.5)
        return False

    hand = Hand(worker, fake_grade).start()
    for node in three_nodes:
        node.stop()
        for _ in range(20):
            submit()
        until(swept, "all are graded with one node dead", 3 * PATIENCE)
        node.start()
        until(lambda: in_step(web), "it has caught up", 3 * PATIENCE)
    hand.stop()
    for machine in (web, worker):
        machine.close()
    with web.database.read() as db:
        assert db.execute(text(GRADED_TWICE)).all() == []


def in_step(machine: Machine) -> bool:
    """Whether the three nodes hold the stream, none behind."""
    connection = machine.engine.connection
    try:
        info = connection.run_blocking(lambda: connection.jetstream.stream_info("work"), PATIENCE)
    except NatsUnavailableError:
        return False
    others = (info.cluster.replicas or []) if info.cluster else []
    return len(others) == 2 and all(one.current and not one.offline for one in others)


def graded(machine: Machine) -> list[str]:
    with machine.database.read() as db:
        return sorted(str(one) for (one,) in db.execute(text("SELECT submission_id FROM grading")))
