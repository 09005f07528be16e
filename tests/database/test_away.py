"""PostgreSQL that does not answer for a while, and processes that fall silent with something locked."""

from __future__ import annotations

import asyncio
import os
import threading
from contextlib import closing, contextmanager

import psycopg
import pytest
from sqlalchemy import Connection, text
from sqlalchemy.exc import DBAPIError, OperationalError

from server.base.app_services import add_services
from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.database import Database, is_unavailable
from server.database import engine as engines
from server.queue import repository as queue
from server.queue.interfaces import Lease
from server.queue.lease_owner import process_owner
from server.queue.worker import Worker
from server.submissions import job_events as events_module
from server.submissions.job_events import JobEvents
from tests.support.quick import in_a_loop
from tests.support.service import QUIET, Site, opened

NOWHERE = "postgresql+psycopg://nobody@127.0.0.1:1/nothing"


def away() -> OperationalError:
    return OperationalError("SELECT 1", {}, psycopg.OperationalError("the database system is starting up"))


@pytest.fixture(autouse=True)
def _asked_again_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engines, "RETRY_SECONDS", 0.01)


def failure(database: Database, statement: str) -> DBAPIError:
    with pytest.raises(DBAPIError) as raised, database.write() as db:
        db.execute(text(statement))
    return raised.value


def test_what_is_away_is_told_from_what_is_wrong(postgres_url: str, settings: Settings) -> None:
    shared = settings.model_copy(update={"database_url": postgres_url})
    for url, statement, expected in [
        (NOWHERE, "SELECT 1", True),
        (shared.sqlalchemy_url, "SELECT pg_terminate_backend(pg_backend_pid())", True),
        (shared.sqlalchemy_url, "SELECT 1/0", False),
        (shared.sqlalchemy_url, "SELECT * FROM nothing_of_that_name", False),
        (settings.sqlalchemy_url, "SELECT * FROM nothing_of_that_name", False),
    ]:
        with closing(Database(url)) as database:
            assert is_unavailable(failure(database, statement)) is expected, (url, statement)


def test_a_transaction_frozen_with_the_lock_of_all_is_undone(
    postgres_url: str, settings: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that puts a job and then freezes: the others wait briefly, and its transaction fails."""
    shared = settings.model_copy(update={"database_url": postgres_url})
    bound = queue.func.set_config("idle_in_transaction_session_timeout", "100ms", True)
    monkeypatch.setattr(queue, "_set_idle_timeout", bound)
    with contextmanager(opened)(shared) as database:
        frozen, thawed, undone = threading.Event(), threading.Event(), list[bool]()

        def freeze() -> None:
            try:
                with database.write() as db:
                    QUIET.enqueue(db, "bake", "frozen")
                    frozen.set()
                    thawed.wait(300)
                    db.execute(text("SELECT 1"))
            except DBAPIError as error:
                undone.append(is_unavailable(error))
                frozen.set()

        thread = threading.Thread(target=freeze)
        thread.start()
        assert frozen.wait(300)
        monkeypatch.undo()  # only the frozen one has so little time
        with database.write() as db:
            QUIET.enqueue(db, "bake", "next")
        thawed.set()
        thread.join(300)
        assert undone == [True]
        with database.read() as db:
            assert db.execute(text("SELECT key FROM job")).scalars().all() == ["next"]


def test_every_transaction_has_its_bound(postgres_url: str, settings: Settings) -> None:
    with closing(Database(settings.model_copy(update={"database_url": postgres_url}).sqlalchemy_url)) as database:
        for _ in range(2):
            with database.read() as db:
                assert db.execute(text("SHOW idle_in_transaction_session_timeout")).scalar_one() == "1min"
            with database.write() as db:
                queue.lock_enqueueing(db)
                assert db.execute(text("SHOW idle_in_transaction_session_timeout")).scalar_one() == "5s"
            with database.write() as db:
                QUIET.enqueue(db, "bake", "a")
            with database.write() as db:
                lease = QUIET.claim(db, process_owner(os.getpid()), ["bake"], 60.0)
            assert lease is not None
            with database.write() as db:
                assert QUIET.finish(db, lease)
                assert db.execute(text("SHOW idle_in_transaction_session_timeout")).scalar_one() == "5s"


def test_who_asks_meanwhile_is_told_to_come_back(site: Site) -> None:
    headers = site.token()
    with closing(Database(NOWHERE)) as nowhere:
        add_services(site.app, nowhere)
        answer = site.client.get("/api/v1/submissions/none", headers=headers)
        page = site.client.get("/compte", headers={"Cookie": f"{SESSION_COOKIE}=x"})
    assert (answer.status_code, answer.headers["retry-after"]) == (503, "2")
    assert answer.json()["type"].endswith("indisponible")
    assert (page.status_code, "réessayez dans quelques secondes" in page.text) == (503, True)
    assert "127.0.0.1" not in answer.text + page.text


def test_who_starts_meanwhile_waits_for_a_while(postgres_url: str, settings: Settings) -> None:
    shared = settings.model_copy(update={"database_url": postgres_url})
    with closing(Database(shared.sqlalchemy_url)) as database:
        refusals, real = [away(), away()], database.engine.connect

        def connect() -> Connection:
            if refusals:
                raise refusals.pop()
            return real()

        database.engine.connect = connect  # type: ignore[method-assign]
        database.wait_until_available(300.0)
        assert not refusals
    with closing(Database(NOWHERE)) as nowhere, pytest.raises(OperationalError):
        nowhere.wait_until_available(0.0)


class Step:
    def __init__(self, number: int) -> None:
        self.number, self.done = number, number == 2

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Step) and other.number == self.number

    __hash__ = None  # type: ignore[assignment]


def test_who_follows_meanwhile_goes_on_afterwards(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(events_module, "SAFETY_POLL", 0.01)

    def reading(steps: list[int | Exception]) -> list[int]:
        left = iter(steps)

        def read() -> Step:
            step = next(left)
            if isinstance(step, Exception):
                raise step
            return Step(step)

        async def follow() -> list[int]:
            return [step.number async for step in JobEvents().follow("a", read)]

        return in_a_loop(asyncio.wait_for(follow(), 300))

    assert reading([away(), 0, away(), away(), 1, away(), 2]) == [0, 1, 2]
    with pytest.raises(ZeroDivisionError):
        reading([0, ZeroDivisionError(), 2])


class Once:
    """A job whose end PostgreSQL does not take at first."""

    def __init__(self, *refusals: Exception) -> None:
        self.refusals, self.runs, self.recorded = [*refusals], 0, 0

    def read(self, _db: object, lease: Lease) -> str:
        return lease.key

    def run(self, work: str) -> str:
        self.runs += 1
        return work

    def record(self, _db: object, _work: str, _result: str) -> None:
        if self.refusals:
            raise self.refusals.pop()
        self.recorded += 1

    def give_up(self, _db: object, lease: Lease) -> None:
        raise AssertionError(lease)


def test_a_result_waits_for_the_database(sqlite: Database, settings: Settings, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is done twice for it, and no try is counted."""
    monkeypatch.setattr("server.queue.job_runner.DATABASE_PAUSE", 0.001)
    task = Once(away(), away())
    with sqlite.write() as db:
        QUIET.enqueue(db, "bake", "a")
    worker = Worker(sqlite, QUIET, settings, {"bake": task})  # type: ignore[dict-item]
    assert worker.run_one()
    assert (task.runs, task.recorded) == (1, 1)
    assert not worker.run_one()
