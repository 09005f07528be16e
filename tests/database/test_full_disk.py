"""A full disk: nothing is stored by halves, who sends is told, and a verdict waits for room."""

from __future__ import annotations

import sqlite3
import stat
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event, select, text

from graders.core.contract.findings import Judgement
from server.base.settings import Settings
from server.cli import main
from server.database import Database
from server.database.migrate import upgrade
from server.gradebook.models import Grading
from server.grading.grading_task import GradingInput
from server.queue import job_runner
from server.submissions.models import Submission
from tests.support.service import EXERCISE, Site, fake_grade

LONG_CODE = "x = 1  # " + "long " * 10_000
UNBOUNDED_PAGES = 1 << 30


class Disk:
    """The disk of an SQLite file, which is full when asked to be: its connections then take no more pages."""

    def __init__(self, database: Database) -> None:
        self.max_pages = UNBOUNDED_PAGES
        event.listen(database.engine, "checkout", self._bound)

    def fill(self) -> None:
        self.max_pages = 1  # SQLite: at least those that there are

    def free(self) -> None:
        self.max_pages = UNBOUNDED_PAGES

    def _bound(self, connection: Any, _record: object, _proxy: object) -> None:
        connection.execute(f"PRAGMA max_page_count = {self.max_pages}")


@pytest.fixture
def disk(site: Site) -> Disk:
    return Disk(site.database)


def test_a_submission_that_does_not_fit_is_refused_and_may_be_sent_again(site: Site, disk: Disk) -> None:
    headers = site.token()
    disk.fill()
    answer = site.client.post("/api/v1/submissions", json={"exercise": EXERCISE, "code": LONG_CODE}, headers=headers)
    assert (answer.status_code, answer.headers["Retry-After"]) == (507, "60")
    assert answer.json()["type"].endswith("disque-plein")
    assert "pas enregistré" in answer.json()["detail"]
    with site.database.read() as db:
        assert not db.execute(select(Submission.id)).all()
    disk.free()
    site.submit(headers, LONG_CODE)


def test_a_page_says_that_nothing_was_stored(site: Site, disk: Disk) -> None:
    disk.fill()
    module, slug = EXERCISE.split("/")
    answer = site.client.post(f"/{module}/exercices/{slug}/soumissions", data={"code": LONG_CODE})
    assert answer.status_code == 507, answer.text
    assert "pas enregistré" in answer.text


def test_a_verdict_waits_for_room(site: Site, disk: Disk, monkeypatch: pytest.MonkeyPatch) -> None:
    def grade_and_fill(graded: GradingInput) -> Judgement:
        judgement = fake_grade(graded)
        disk.fill()
        return Judgement(judgement.verdict, {"b": {"kind": "long", "text": LONG_CODE}})

    waits: list[float] = []

    def wait(seconds: float) -> None:
        waits.append(seconds)
        if len(waits) == 3:
            disk.free()

    site.submit(site.token())
    monkeypatch.setattr(job_runner.time, "sleep", wait)
    site.worker_with(grade_and_fill).run_one()
    with site.database.read() as db:
        assert db.execute(select(Grading.score)).scalar_one() == 1.0
    assert waits == [job_runner.DATABASE_PAUSE] * 3


def test_a_start_on_a_full_disk_is_one_clear_line(
    settings: Settings, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(Database(settings.sqlalchemy_url)) as older:
        upgrade(older.engine, "0016")
        Disk(older).fill()
        monkeypatch.setattr("server.cli.serve.Database", lambda _url: older)
        assert main(["serve", "--data", str(settings.data_dir), "--port", "0"]) == 2
    (*_, line) = capsys.readouterr().err.strip().splitlines()
    assert line.startswith("balise : ")
    assert "plein" in line


def test_a_second_database_object_keeps_the_locks_of_the_first(tmp_path: Path) -> None:
    """Another process that closes the file must not take it for unused, and remove its log."""
    url = f"sqlite:///{tmp_path}/balise.sqlite3"
    other = "import sqlite3, sys; sqlite3.connect(sys.argv[1]).execute('SELECT * FROM alembic_version').fetchall()"
    with closing(Database(url)) as first:
        upgrade(first.engine)
        with first.engine.connect():
            Database(url).close()
            subprocess.run([sys.executable, "-c", other, str(tmp_path / "balise.sqlite3")], check=True)
            assert (tmp_path / "balise.sqlite3-wal").exists()


@pytest.mark.parametrize("older", [False, True])
def test_the_file_of_the_database_is_for_its_owner_alone(tmp_path: Path, older: bool) -> None:
    """Also where an older version made it with the modes of the umask."""
    folder = tmp_path / "data"
    if older:
        folder.mkdir(mode=0o755)
        sqlite3.connect(folder / "balise.sqlite3").close()
        folder.joinpath("balise.sqlite3").chmod(0o644)
    with closing(Database(f"sqlite:///{folder}/balise.sqlite3")) as database:
        with database.write() as db:
            db.execute(text("CREATE TABLE une (x INTEGER)"))
        modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in [folder, *folder.iterdir()]}
    assert modes.pop("data") == 0o700
    assert modes
    assert set(modes.values()) == {0o600}
