"""Servers that others wrote, each in an environment of its own (`.ci/peers`), and what their tests share."""

from __future__ import annotations

import html
import os
import re
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

import httpx2 as httpx

from server.base.settings import Settings
from server.database import Database
from tests.support.live import until

CACHE = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
PEERS = Path(os.environ.get("BALISE_PEERS", CACHE / "balise" / "peers"))
TRIES = 3


def free_port() -> int:
    with socket.socket() as sought:
        sought.bind(("127.0.0.1", 0))
        return int(sought.getsockname()[1])


@contextmanager
def running(command: list[str], address: str) -> Iterator[None]:
    """Run a server until it is needed no more; it is there when its address answers."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def answers() -> bool:
        assert process.poll() is None, process.stderr and process.stderr.read()
        try:
            return httpx.get(address).status_code < 500
        except httpx.TransportError:
            return False

    try:
        until(answers, f"{address} answers")
        yield
    finally:
        process.kill()
        process.communicate()


def read(data: Path, query: Any) -> list[Any]:
    database = Database(Settings(data_dir=data).sqlalchemy_url)
    with database.read() as db:
        rows = list(db.execute(query).scalars())
    database.engine.dispose()
    return rows


def submit(client: httpx.Client, page: httpx.Response, **fields: str) -> httpx.Response:
    """Send the form of a page with its hidden fields and these."""
    action = re.search(r'<form[^>]*?action="([^"]*)"', page.text)
    hidden = dict(re.findall(r'<input[^>]*?type="hidden"[^>]*?name="([^"]+)"[^>]*?value="([^"]*)"', page.text))
    address = urljoin(str(page.url), html.unescape(action[1]) if action else "")
    return client.post(address, data={**hidden, **fields}, headers={"Referer": str(page.url)})


def seconds(action: Callable[[], object]) -> float:
    start = time.perf_counter()
    action()
    return time.perf_counter() - start
