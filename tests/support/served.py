"""One `balise serve` for all tests that need any: it takes seconds to start, and its templates to be warm."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass
from pathlib import Path

import pytest

from server.base.settings import Settings
from server.database import Database
from tests.support.live import Live
from tests.support.shared import shared

#: A platform of a test is on this machine, without TLS.
LOCAL_PLATFORMS = {"BALISE_PLATFORM_HTTP": "1", "BALISE_PLATFORM_NETWORKS": "127.0.0.0/8,::1/128"}


@dataclass(frozen=True)
class Server:
    address: str
    teacher_link: str
    data: str

    def __str__(self) -> str:
        """Return the fields as one line, which another process splits again."""
        return " ".join(astuple(self))

    def open_database(self) -> Database:
        return Database(Settings(data_dir=Path(self.data)).sqlalchemy_url)


@contextmanager
def serving(data: Path, **values: str) -> Iterator[Server]:
    """Serve a data folder, with one worker; `values` are variables of the environment."""
    live = Live(data, BALISE_WORKERS="1", **values)
    try:
        link = re.search(r"http://\S+/bienvenue/\S+", live.output)
        assert link, live.output
        yield Server(live.address, link[0], str(data))
    finally:
        live.process.terminate()
        live.process.wait(300)
        live.close()


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """One for all the processes of xdist."""
    with shared(tmp_path_factory, "balise-serve", _serving) as told:
        yield Server(*told.split())


@contextmanager
def _serving(folder: Path) -> Iterator[str]:
    with serving(folder / "data", **LOCAL_PLATFORMS) as server:
        yield str(server)
