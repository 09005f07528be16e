"""`balise doctor --cluster`: what it says of machines that share a database and a NATS server, and how it ends."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import pytest
from sqlalchemy import select

from server.base.settings import Settings
from server.cli import main
from server.database import Database
from server.health import cluster_check, repository
from server.queue.interfaces import WorkerCapabilities
from server.submissions.service import GRADE
from tests.support.cluster import Hand, Machine, until

NOWHERE = "nats://127.0.0.1:1"


@pytest.fixture
def environment(shared_settings: Settings, monkeypatch: pytest.MonkeyPatch) -> Settings:
    monkeypatch.setenv("BALISE_DATA_DIR", str(shared_settings.data_dir))
    monkeypatch.setenv("BALISE_DATABASE_URL", str(shared_settings.database_url))
    monkeypatch.setenv("BALISE_NATS_URL", shared_settings.nats_url)
    monkeypatch.setattr(cluster_check, "SLOW_DATABASE_MS", 1e6)  # how fast this machine is proves nothing
    monkeypatch.setattr(cluster_check, "SLOW_NATS_MS", 1e6)
    return shared_settings


def told(capsys: Any) -> tuple[int, str]:
    status = main(["doctor", "--cluster"])
    return status, capsys.readouterr().out


def test_cluster_check_prints_one_line_a_finding(environment: Settings, machines: list[Machine], capsys: Any) -> None:
    machine = Machine(environment).start().up()
    machines.append(machine)
    hand = Hand(machine).start()
    until(lambda: "✓ correcteurs" in told(capsys)[1], "a worker is free")
    status, text = told(capsys)
    hand.stop()
    assert status == 0, text
    for line in ("base de données", "schéma", "horloges", "NATS", "JetStream", "flux"):
        assert f"✓ {line} : " in text, text
    assert "✗" not in text
    status, text = told(capsys)
    assert status == 0, "a worker may come later"


def test_cluster_check_reports_jobs_waiting_for_another_version(
    environment: Settings, machines: list[Machine], capsys: Any
) -> None:
    machine = Machine(environment).start().up()
    machines.append(machine)
    with machine.database.write() as db:
        machine.queue.enqueue(db, GRADE, "a", required_version="l20/poses@abc")
        assert machine.queue.mark_refused(db, [GRADE], WorkerCapabilities([], 60.0))
    status, text = told(capsys)
    assert status == 0
    assert "! versions : 1 travail attend un correcteur de l20/poses, version abc" in text


def test_cluster_check_reports_a_nearly_full_database(
    environment: Settings, machines: list[Machine], monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    machines.append(Machine(environment).start().up())
    with closing(Database(environment.sqlalchemy_url)) as database, database.read() as db:
        opened, most = repository.count_open_and_allowed_connections(db)
        with database.read() as other:
            other.execute(select(1))
            assert repository.count_open_and_allowed_connections(db) == (opened, most), (
                "in one transaction, PostgreSQL says the same"
            )
            assert opened >= 1
    monkeypatch.setattr(repository, "count_open_and_allowed_connections", lambda _: (80, 97))
    status, text = told(capsys)
    assert status == 0
    assert "! connexions à la base : 80 ouvertes, 97 au plus" in text
    assert "max_connections : 50 pour chaque serveur web" in text
    monkeypatch.setattr(repository, "count_open_and_allowed_connections", lambda _: (77, 97))
    assert "✓ connexions à la base" in told(capsys)[1]


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        ({"BALISE_NATS_URL": NOWHERE}, "✗ NATS : injoignable"),
        ({"BALISE_NATS_URL": ""}, "✗ NATS : aucun serveur"),
        ({"BALISE_NATS_URL": "", "BALISE_DATABASE_URL": "sqlite:///x.db"}, "✗ base de données : SQLite"),
        ({"BALISE_NATS_URL": "", "BALISE_DATABASE_URL": "postgresql://x@127.0.0.1:1/x"}, "✗ base de données : injoig"),
    ],
)
def test_cluster_check_reports_problems_by_its_exit_status(
    environment: Settings, monkeypatch: pytest.MonkeyPatch, capsys: Any, changed: dict[str, str], line: str
) -> None:
    for name, value in changed.items():
        monkeypatch.setenv(name, value)
    status, text = told(capsys)
    assert (status, line in text, "remède" in text) == (1, True, True), text


def test_cluster_check_reports_a_missing_stream_without_creating_it(environment: Settings, capsys: Any) -> None:
    for _ in range(2):
        status, text = told(capsys)
        assert (status, "✗ flux : le flux « work » n’existe pas" in text) == (1, True), text


def test_nats_without_a_shared_database_is_refused(
    environment: Settings, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.delenv("BALISE_DATABASE_URL")
    assert main(["worker"]) == 2
    assert "réglez aussi BALISE_DATABASE_URL" in capsys.readouterr().err
