"""A real `balise serve`, in processes of its own."""

from __future__ import annotations

import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import httpx

from server.base.files import write_atomically
from server.course.start_cache import CACHE_FILE

PROJECT = Path(__file__).resolve().parents[2]
PASSWORD = "une phrase assez longue"
PATIENCE = 300.0  # seconds, against hanging alone: each wait ends by what it waits for
AUDIT = """
CREATE TABLE audit (id TEXT);
CREATE TRIGGER audit_graded AFTER INSERT ON grading
BEGIN INSERT INTO audit VALUES (NEW.submission_id); END;
"""


def environment(**values: str) -> dict[str, str]:
    clean = {name: value for name, value in os.environ.items() if not name.startswith("BALISE_")}
    cold = {"BALISE_WARM_UP": "0", "BALISE_WARM_FIGURES": "0"}
    return {**clean, "PYTHONPATH": str(PROJECT), **cold, **values}


def balise(*arguments: str, **values: str) -> subprocess.CompletedProcess[str]:
    """Runs a command of the command line to its end."""
    command = [sys.executable, "-m", "server", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment(**values), check=False)


def until(condition: Callable[[], bool], what: str) -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, f"still not: {what}"
        time.sleep(0.02)


def rows(data: Path, query: str) -> list[Any]:
    with closing(sqlite3.connect(data / "balise.sqlite3")) as connection:
        return connection.execute(query).fetchall()


def count(data: Path, condition: str, table: str = "submission") -> int:
    return int(rows(data, f"SELECT count(*) FROM {table} WHERE {condition}")[0][0])


WAITING = "grading_id IS NULL"
RUNNING = "lease_token IS NOT NULL"


def children(pid: int) -> list[int]:
    """The children of a process, and theirs; none of a thread that ends meanwhile."""
    found = []
    for thread in Path(f"/proc/{pid}/task").glob("*/children"):
        with suppress(OSError):
            for child in thread.read_text().split():
                found += [int(child), *children(int(child))]
    return found


def state_of(pid: int) -> str:
    """Return the state of a process as `ps` shows it (T: stopped, Z: zombie); X where it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return "X"


def alive(pid: int) -> bool:
    return state_of(pid) not in "ZX"


def start_cache() -> Path:
    """Return where tests keep the start cache: checking the course takes most of a first start, and is done once."""
    return Path(tempfile.gettempdir()) / f"balise-{os.getuid()}-{CACHE_FILE}"


class Live:
    """A server on a data folder; `address` once it has said that it is ready.

    `program` is the module that runs: without `"server"` itself, the wall that takes long to try is not tried.
    """

    def __init__(self, data: Path, *, program: str = "tests.support.serve_soon", **values: str) -> None:
        command = [sys.executable, "-m", program, "serve", "--port", "0", "--data", str(data)]
        self.errors = data.parent / "errors.log"
        data.mkdir(mode=0o700, parents=True, exist_ok=True)
        if start_cache().exists() and not (data / CACHE_FILE).exists():
            shutil.copyfile(start_cache(), data / CACHE_FILE)
        self._errors = self.errors.open("a")
        self.process = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
            env=environment(**values),
            process_group=0,
        )
        self.output = ""
        self.address = self._ready()
        write_atomically(start_cache(), (data / CACHE_FILE).read_bytes())
        self.client = httpx.Client(base_url=self.address, timeout=PATIENCE)

    def _ready(self) -> str:
        assert self.process.stdout
        for line in self.process.stdout:
            self.output += line
            if "Ctrl+C" in line:
                found = re.search(r"prête : (http://\S+?)/\n", self.output)
                assert found, self.output
                return found[1]
        raise AssertionError(f"the server did not start: {self.output}")

    def sign_up_teacher(self) -> None:
        found = re.search(r"/bienvenue/\S+", self.output)
        assert found, self.output
        form = {"name": "Prof", "login": "prof", "password": PASSWORD}
        assert self.client.post(found[0], data=form).status_code == 303

    def token(self) -> str:
        page = self.client.post("/compte/jetons", data={"label": "essai", "password": PASSWORD}).text
        found = re.search(r'id="jeton">([^<]+)<', page)
        assert found, page
        return found[1]

    def workers(self) -> list[int]:
        """The processes that the server has started itself."""
        text = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text()
        return [int(pid) for pid in text.split()]

    def kill(self) -> list[int]:
        """kill -9 of the server alone; returns the processes that it had below it."""
        below = children(self.process.pid)
        self.process.send_signal(signal.SIGKILL)
        self.process.wait(PATIENCE)
        self.close()
        return below

    def close(self) -> None:
        self.client.close()
        self._errors.close()
        if self.process.stdout:
            self.process.stdout.close()
