"""The service that is measured, in processes of its own: on SQLite, on PostgreSQL, on PostgreSQL with NATS."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.support.cluster import Nats
from tests.support.live import PATIENCE, Live, environment
from tests.support.postgres import postgres_of_the_wheel

ENGINES = ("sqlite", "postgresql", "nats")
READY = "Balise corrige"
WARM = {"BALISE_WARM_UP": "1", "BALISE_WARM_FIGURES": "1"}  # as it serves; tests start it cold


@dataclass(frozen=True)
class Service:
    """`url` of its database; `parts`: the processes of each part, whose descendants count with them."""

    addresses: tuple[str, ...]
    url: str
    parts: Mapping[str, Sequence[int]]


class UnsuitableError(Exception):
    """This engine does not do that."""


@contextmanager
def started(engine: str, web: int, workers: int, folder: Path) -> Iterator[Service]:
    """Web processes grade by themselves where there is no NATS; with it, graders are commands of their own."""
    if engine == "sqlite" and web > 1:
        raise UnsuitableError("a SQLite file has one web process")
    with ExitStack() as stack:
        parts: dict[str, Sequence[int]] = {}
        settings = {} if engine == "sqlite" else stack.enter_context(_postgresql(parts))
        if engine == "nats":
            settings["BALISE_NATS_URL"] = stack.enter_context(_nats(folder, parts))
        served = [
            stack.enter_context(_web(folder / f"web{number}", settings, 0 if number or engine == "nats" else workers))
            for number in range(web)
        ]
        parts["web"] = [one.process.pid for one in served]
        if engine == "nats":
            parts["graders"] = [
                stack.enter_context(_worker(folder / f"worker{number}", settings)) for number in range(workers)
            ]
        url = settings.get("BALISE_DATABASE_URL", f"sqlite:///{folder / 'web0' / 'data' / 'balise.sqlite3'}")
        yield Service(
            tuple(one.address for one in served), url.replace("postgresql://", "postgresql+psycopg://"), parts
        )


@contextmanager
def _web(folder: Path, settings: Mapping[str, str], workers: int) -> Iterator[Live]:
    folder.mkdir()
    live = Live(folder / "data", **settings, BALISE_WORKERS=str(workers), **WARM)
    try:
        yield live
    finally:
        live.process.terminate()
        live.process.wait(PATIENCE)
        live.close()
        print("".join(f"! {line}\n" for line in live.errors.read_text().splitlines()[-20:]), end="", file=sys.stderr)


@contextmanager
def _worker(folder: Path, settings: Mapping[str, str]) -> Iterator[int]:
    folder.mkdir()
    values = environment(**settings, **WARM, BALISE_DATA_DIR=str(folder))
    command = [sys.executable, "-m", "server", "worker"]
    with (folder / "errors.log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True, env=values)
    assert process.stdout
    try:
        if not any(READY in line for line in iter(process.stdout.readline, "")):
            raise RuntimeError((folder / "errors.log").read_text())
        yield process.pid
    finally:
        process.terminate()
        process.wait(PATIENCE)
        process.stdout.close()


@contextmanager
def _postgresql(parts: dict[str, Sequence[int]]) -> Iterator[dict[str, str]]:
    with postgres_of_the_wheel() as server:
        parts["database"] = [int((server.pgdata / "postmaster.pid").read_text().split()[0])]
        yield {"BALISE_DATABASE_URL": server.get_uri()}


@contextmanager
def _nats(folder: Path, parts: dict[str, Sequence[int]]) -> Iterator[str]:
    nats = Nats(folder / "nats")
    nats.start()
    try:
        assert nats.process
        parts["NATS"] = [nats.process.pid]
        yield nats.url
    finally:
        nats.stop()
