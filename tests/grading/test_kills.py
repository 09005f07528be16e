"""kill -9 and SIGSTOP of everything that grades, at random moments: one verdict each, nothing lost, nothing left."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from server.course import Course
from tests.support.live import AUDIT, RUNNING, WAITING, Live, alive, children, count, environment, rows, until
from tests.support.service import EXERCISE

pytestmark = pytest.mark.slow

#: Worker and server are killed by the story of `test_processes` too: here they are when there are more rounds.
ALWAYS = ["template", "watcher", "stopped worker", "remote"]
VICTIMS = [*ALWAYS, "worker", "server"]
#: By hand: many more rounds, and other moments.
MORE_ROUNDS = int(os.environ.get("BALISE_TEST_ROUNDS", "0"))
SEED = int(os.environ.get("BALISE_TEST_SEED", "5"))
AT_ONCE = 5
SETTINGS = {
    "BALISE_WORKERS": "2",
    "BALISE_LEASE_SECONDS": "2",
    "BALISE_SUBMISSION_BURST": "100000",
    "BALISE_WAITING_EACH": "100000",
}


class Field:
    """A server, a worker from elsewhere on the same database, and what befalls them."""

    def __init__(self, data: Path, code: str) -> None:
        self.data, self._code, self.sent = data, code, list[str]()
        self.live = Live(data, **SETTINGS)
        self.live.sign_up_teacher()
        self._headers = {"Authorization": f"Bearer {self.live.token()}"}
        with closing(sqlite3.connect(data / "balise.sqlite3")) as connection:
            connection.executescript(AUDIT)
        self.log = (data.parent / "remote.log").open("a+")
        self.remote = self._elsewhere()

    def _elsewhere(self) -> subprocess.Popen[bytes]:
        """`balise worker`, once it is there to grade."""
        values = {**SETTINGS, "BALISE_DATABASE_URL": f"sqlite:///{self.data / 'balise.sqlite3'}"}
        command = [sys.executable, "-m", "server", "worker"]
        started = subprocess.Popen(command, stderr=self.log, env=environment(**values))
        until(lambda: catches(started.pid, signal.SIGTERM), "the remote worker begins")
        return started

    def submit(self) -> None:
        for _ in range(AT_ONCE):
            body = {"exercise": EXERCISE, "code": self._code}
            answer = self.live.client.post("/api/v1/submissions", json=body, headers=self._headers)
            assert answer.status_code == 202
            self.sent.append(answer.json()["id"].replace("-", ""))

    def holders(self) -> list[int]:
        """The workers that are grading."""
        owners = rows(self.data, f"SELECT lease_owner FROM job WHERE {RUNNING}")
        return [int(owner.split("|")[3]) for (owner,) in owners]

    def grading(self, wanted: list[int]) -> int:
        """One of these workers, while it grades."""
        until(lambda: self._busy() and bool(set(self.holders()) & set(wanted)), f"one of {wanted} grades")
        return next((pid for pid in self.holders() if pid in wanted), wanted[0])

    def _busy(self) -> bool:
        """There is work, for a worker that has only just begun too."""
        if not self.holders():
            self.submit()
        return True

    def drained(self) -> None:
        until(lambda: count(self.data, WAITING) == 0, "everything is graded")

    def strike(self, victim: str, chance: random.Random) -> None:
        time.sleep(chance.uniform(0.0, 0.5))
        local = self.live.workers()
        match victim:
            case "template" | "watcher":
                until(lambda: any(map(watchers, self.live.workers())), "there are templates")
                chosen = chance.choice([one for worker in self.live.workers() for one in watchers(worker)])
                end(chosen if victim == "watcher" else children(chosen)[0])
            case "worker":
                end(self.grading(local))
            case "remote":
                below = children(self.grading([self.remote.pid]))
                self.remote.kill()
                self.remote.wait()
                until(lambda: not any(map(alive, below)), "nothing is left of the remote worker")
                self.remote = self._elsewhere()
            case "stopped worker":
                self._stop(self.grading(local))
            case "server":
                below = self.live.kill()
                until(lambda: not any(map(alive, below)), "everything below the server is gone")
                self.live = Live(self.data, **SETTINGS)

    def _stop(self, worker: int) -> None:
        """Another takes over when its lease has run out; what it says when it wakes up is refused."""
        os.kill(worker, signal.SIGSTOP)
        while not self._writable():  # it was stopped with the only pen of SQLite in its hand
            os.kill(worker, signal.SIGCONT)
            time.sleep(0.05)
            os.kill(worker, signal.SIGSTOP)
        held, told = worker in self.holders(), self._refusals()
        self.drained()
        os.kill(worker, signal.SIGCONT)
        until(lambda: self._refusals() > told or not held, "its verdict is refused")

    def _writable(self) -> bool:
        with closing(sqlite3.connect(self.data / "balise.sqlite3", timeout=0.5)) as connection:
            try:
                connection.execute("BEGIN IMMEDIATE")
            except sqlite3.OperationalError:
                return False
            return True

    def _refusals(self) -> int:
        return self.live.errors.read_text().count("the lease was lost")

    def close(self) -> None:
        below = [*children(self.live.process.pid), *children(self.remote.pid)]
        for process in (self.live.process, self.remote):
            process.terminate()
            assert process.wait(300) == 0
        self.live.close()
        self.log.close()
        until(lambda: not any(map(alive, below)), "nothing is left running")


def watchers(worker: int) -> list[int]:
    """What watches over the templates of a worker, which each have come up; below a template are students' programs."""
    threads = Path(f"/proc/{worker}/task").glob("*/children")
    started = [int(child) for thread in threads for child in thread.read_text().split()]
    return [child for child in started if children(child)]


def catches(pid: int, number: signal.Signals) -> bool:
    """Whether a process has a handler of its own for a signal."""
    status = dict(line.split(":", 1) for line in Path(f"/proc/{pid}/status").read_text().splitlines())
    return bool(int(status["SigCgt"], 16) >> (number - 1) & 1)


def end(pid: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


@pytest.fixture
def field(tmp_path: Path, course: Course) -> Iterator[Field]:
    code = "import time\ntime.sleep(0.3)\n" + course.exercises[EXERCISE].solution
    one = Field(tmp_path / "data", code)
    yield one
    for process in (one.live.process, one.remote):
        if process.poll() is None:
            process.kill()


def test_whatever_is_killed_each_gets_its_one_verdict(field: Field) -> None:
    chance = random.Random(SEED)
    for victim in [*(chance.choice(VICTIMS) for _ in range(MORE_ROUNDS)), *chance.sample(ALWAYS, len(ALWAYS))]:
        field.submit()
        field.strike(victim, chance)
        field.drained()
    audit = Counter(one for (one,) in rows(field.data, "SELECT id FROM audit"))
    assert audit == Counter(field.sent), "each is graded exactly once"
    assert rows(field.data, "SELECT DISTINCT outcome, score FROM grading") == [("ok", 1.0)]
    assert count(field.data, "TRUE", "job") == 0
    field.close()
