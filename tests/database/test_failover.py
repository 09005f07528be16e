"""Debian's PostgreSQL with a standby that takes over: nothing that was acknowledged is lost, nothing graded twice."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
from sqlalchemy import select, text
from sqlalchemy.exc import DBAPIError

from server.base.settings import Settings
from server.database import Database, is_unavailable
from server.gradebook.models import Grading
from server.identity.models import Account
from server.submissions.service import SubmissionService
from tests.support.cluster import free_port, until
from tests.support.quick import migrated
from tests.support.service import ADDRESS, EXERCISE, QUIET, new_account, worker_of

BEFORE, AFTER = 30, 30


class Pair:
    """A primary whose commits wait for its standby."""

    def __init__(self, programs: Path, folder: Path) -> None:
        self._programs, self._folder = programs, folder
        self._user = "postgres" if os.geteuid() == 0 else None
        self.ports = free_port(), free_port()
        if self._user:
            shutil.chown(folder, self._user)
        self._run("initdb", "-A", "trust", "-U", "postgres", "-D", self._data(0))
        self._start(0)
        self._run("pg_basebackup", "-U", "postgres", *self._at(0), "-D", self._data(1), "-R", "-X", "stream")
        self._start(1)
        with closing(Database(self.url_of(0))) as first:
            with first.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
                connection.execute(text("ALTER SYSTEM SET synchronous_standby_names = '*'"))
                connection.execute(text("SELECT pg_reload_conf()"))
            until(lambda: self._follows(first), "commits wait for the standby")

    def _follows(self, first: Database) -> bool:
        with first.read() as db:
            return db.execute(text("SELECT sync_state FROM pg_stat_replication")).scalars().all() == ["sync"]

    @property
    def url(self) -> str:
        """As an administrator would write it."""
        hosts = "&".join(f"host=127.0.0.1:{port}" for port in self.ports)
        return f"postgresql://postgres@/postgres?{hosts}&target_session_attrs=read-write"

    def url_of(self, number: int) -> str:
        return f"postgresql+psycopg://postgres@127.0.0.1:{self.ports[number]}/postgres"

    def fail_over(self) -> None:
        """The primary crashes; somebody, or what watches over it, has the standby take its place."""
        self._ctl(0, "-m", "immediate", "stop")
        self._ctl(1, "promote")

    def close(self) -> None:
        for number in (0, 1):
            if (self._folder / str(number) / "postmaster.pid").exists():
                self._ctl(number, "-m", "immediate", "stop")

    def _data(self, number: int) -> str:
        return str(self._folder / str(number))

    def _at(self, number: int) -> tuple[str, ...]:
        return "-h", "127.0.0.1", "-p", str(self.ports[number])

    def _start(self, number: int) -> None:
        options = f"-p {self.ports[number]} -h 127.0.0.1 -k {self._folder}"
        self._ctl(number, "-w", "-o", options, "-l", f"{self._data(number)}.log", "start")

    def _ctl(self, number: int, *arguments: str) -> None:
        self._run("pg_ctl", "-D", self._data(number), *arguments)

    def _run(self, program: str, *arguments: str) -> None:
        command = [str(self._programs / program), *arguments]
        subprocess.run(command, user=self._user, cwd=self._folder, check=True, stdout=subprocess.DEVNULL)


@pytest.fixture
def pair() -> Iterator[Pair]:
    found = sorted(Path("/usr/lib/postgresql").glob("*/bin/pg_basebackup"))
    if not found:
        pytest.skip("no PostgreSQL of Debian's: its package postgresql is not installed")
    with tempfile.TemporaryDirectory(prefix="balise-pair-") as folder:  # pytest's may be entered by nobody else
        one = Pair(found[-1].parent, Path(folder))
        yield one
        one.close()


def patiently(doing: Callable[[], object]) -> None:
    """Again and again while PostgreSQL does not answer, as whoever sends or grades does."""
    deadline = time.monotonic() + 300
    while True:
        try:
            doing()
            return
        except DBAPIError as error:
            if not is_unavailable(error) or time.monotonic() > deadline:
                raise
            time.sleep(0.05)


@pytest.mark.slow
def test_a_standby_takes_over(pair: Pair, settings: Settings) -> None:
    settings = settings.model_copy(update={"database_url": pair.url, "submission_burst": 1000, "waiting_each": 1000})
    with closing(migrated(settings)) as database:
        account, store, sent, ended = (
            new_account(database),
            SubmissionService(settings, QUIET),
            set[str](),
            threading.Event(),
        )

        def grade() -> None:
            worker = worker_of(database, settings)
            while not ended.is_set():
                patiently(worker.run_one)
                time.sleep(0.01)

        grading = threading.Thread(target=grade)
        grading.start()
        for number in range(BEFORE + AFTER):
            if number == BEFORE:
                taking_over = threading.Thread(target=pair.fail_over)
                taking_over.start()
            patiently(lambda number=number: sent.add(send(database, store, account, number)))  # type: ignore[misc]
        taking_over.join()
        until(lambda: graded(database) == Counter(sent), "all are graded, each once")
        ended.set()
        grading.join()


def send(database: Database, store: SubmissionService, account: Account, number: int) -> str:
    with database.write() as db:
        return str(store.submit(db, account, EXERCISE, f"x = {number}", address=ADDRESS, key=str(number)).id)


def graded(database: Database) -> Counter[str]:
    with database.read() as db:
        return Counter(str(one) for one in db.execute(select(Grading.submission_id)).scalars())
