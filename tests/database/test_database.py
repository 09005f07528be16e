"""Migrations, transactions and times, on both databases."""

from __future__ import annotations

import sqlite3
import sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from subprocess import PIPE, Popen
from threading import Barrier
from typing import Any
from uuid import uuid4

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from sqlalchemy import Uuid, column, insert, select, table, text, update

from server.base.files import ROOT
from server.base.settings import Settings
from server.cli import main
from server.database import Database, engine, run_after_commit, table_of
from server.database.migrate import (
    WrongSchemaError,
    alembic_config,
    head_revision,
    is_known_revision,
    require_current_schema,
    upgrade,
)
from server.gradebook.models import Grading
from server.identity.models import Account
from server.limits.models import TokenBucket
from server.submissions.models import Submission
from server.tables import metadata
from tests.support.quick import migrated


def test_migrations_from_an_empty_database_give_the_models_schema(database: Database) -> None:
    with database.engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True, "compare_server_default": True})
        assert compare_metadata(context, metadata) == []


def test_migrating_again_changes_nothing(database: Database) -> None:
    with database.write() as db:
        db.add(Account(name="Ada"))
    upgrade(database.engine)
    with database.read() as db:
        assert db.execute(select(Account.name)).scalars().all() == ["Ada"]


def test_a_writing_transaction_that_raises_leaves_nothing(database: Database) -> None:
    ran: list[str] = []

    def fail_halfway() -> None:
        with database.write() as db:
            db.add(Account(name="Ada"))
            run_after_commit(db, lambda: ran.append("told"))
            db.flush()
            raise RuntimeError("halfway")

    with pytest.raises(RuntimeError, match="halfway"):
        fail_halfway()
    with database.read() as db:
        assert db.execute(select(Account)).first() is None
    assert ran == []


def test_actions_after_commit_see_the_commit(database: Database) -> None:
    seen: list[int] = []

    def look() -> None:
        with database.read() as other:
            seen.append(len(other.execute(select(Account)).all()))

    with database.write() as db:
        db.add(Account(name="Ada"))
        run_after_commit(db, look)
    assert seen == [1]


def test_concurrent_read_modify_write_loses_nothing(database: Database) -> None:
    with database.write() as db:
        db.add(TokenBucket(key="k", tokens=0, updated_at=datetime.now(UTC)))

    def increment(_: int) -> None:
        with database.write() as db:
            row = db.execute(select(TokenBucket).where(TokenBucket.key == "k").with_for_update()).scalar_one()
            row.tokens += 1

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(increment, range(80)))
    with database.read() as db:
        assert db.execute(select(TokenBucket.tokens)).scalar_one() == 80


def test_times_come_back_aware_and_equal(database: Database) -> None:
    noon = datetime(2026, 3, 1, 12, tzinfo=timezone(timedelta(hours=5)))
    with database.write() as db:
        db.add(Account(name="Ada", created_at=noon))
    with database.read() as db:
        read = db.execute(select(Account.created_at)).scalar_one()
    assert read == noon
    assert read.utcoffset() == timedelta(0)


def _new_schema(url: str, name: str) -> str:
    """The address of an empty one of PostgreSQL."""
    with closing(Database(url)) as first, first.engine.begin() as connection:
        connection.execute(text(f"DROP SCHEMA IF EXISTS {name} CASCADE"))
        connection.execute(text(f"CREATE SCHEMA {name}"))
    return f"{url}{'&' if '?' in url else '?'}options=-csearch_path%3D{name}"


def test_processes_that_start_together_migrate_once(postgres_url: str, tmp_path: Path) -> None:
    """Each with an engine of its own, as processes have; on a new SQLite file, and in a new schema of PostgreSQL."""
    schema = _new_schema(postgres_url, "together")
    for url in (f"sqlite:///{tmp_path / 'new' / 'balise.sqlite3'}", schema):
        together = Barrier(4)

        def start(url: str = url, together: Barrier = together) -> None:
            with closing(Database(url)) as database:
                together.wait()
                upgrade(database.engine)
                require_current_schema(database.engine)

        with ThreadPoolExecutor(4) as pool:
            for done in [pool.submit(start) for _ in range(4)]:
                done.result()


def test_revisions_come_and_go_with_their_migration(postgres_url: str, tmp_path: Path) -> None:
    schema = _new_schema(postgres_url, "revised")
    for url in (f"sqlite:///{tmp_path / 'balise.sqlite3'}", schema):
        with closing(Database(url)) as database:
            upgrade(database.engine, "0020")
            account, graded, waits, grading = uuid4(), uuid4(), uuid4(), uuid4()
            sent = {"account_id": account, "exercise": "m/a", "source": b"", "digest": "", "seed": 1}
            found = {"outcome": "ok", "exercise_version": "v", "seed": 1, "verdict": {}, "figures": {}}
            with database.write() as db:
                accounts = table("account", *map(column, ("name", "role", "created_at")), column("id", Uuid()))
                row = {"id": account, "name": "Ada", "role": "student", "created_at": datetime.now(UTC)}
                db.execute(insert(accounts), row)  # of that time: the model has other columns by now
                db.execute(insert(table_of(Submission)), [{"id": one, **sent} for one in (graded, waits)])
                at = dict.fromkeys(("started_at", "finished_at"), datetime.now(UTC))
                db.execute(insert(table_of(Grading)), {"id": grading, "submission_id": graded, **found, **at})
                points = update(table_of(Submission)).where(table_of(Submission).c.id == graded)
                db.execute(points.values(grading_id=grading))
            seen = set()
            for _ in range(2):
                upgrade(database.engine)
                with database.read() as db:
                    revisions = dict(db.execute(select(Submission.id, Submission.revision)).all())
                assert revisions[waits] is None
                seen.add(revisions[graded])
                with database.engine.begin() as connection:
                    command.downgrade(alembic_config(connection), "0020")
                with database.write() as db:
                    db.execute(points.values(digest="other"))
                    db.execute(update(table_of(Grading)).values(outcome="timeout"))
            assert len(seen - {None}) == 2


def test_a_new_file_whose_mode_another_process_changes_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    busy = sqlite3.OperationalError("database is locked")
    busy.sqlite_errorcode = sqlite3.SQLITE_BUSY
    asked: list[str] = []

    class Connection:
        def execute(self, statement: str) -> None:
            asked.append(statement)
            if len(asked) < 3:
                raise busy

    monkeypatch.setattr(engine, "WAL_RETRY_SECONDS", 0.0)
    engine._set_pragma(Connection(), "journal_mode=WAL")
    assert asked == 3 * ["PRAGMA journal_mode=WAL"]
    asked.clear()
    monkeypatch.setattr(engine, "WAL_TIMEOUT", -1.0)
    with pytest.raises(sqlite3.OperationalError):
        engine._set_pragma(Connection(), "journal_mode=WAL")


STARTS = """
import sqlite3
import sys
from alembic import command
from server.database import Database
from server.database.migrate import require_current_schema, upgrade

migrate = command.upgrade
command.upgrade = lambda *args: (migrate(*args), print("migrated"))
database = Database(sys.argv[1])
sys.stdin.readline()  # all at the same time
upgrade(database.engine)
require_current_schema(database.engine)
"""


@pytest.mark.slow
def test_real_processes_that_start_together_migrate_once(postgres_url: str, tmp_path: Path) -> None:
    schema = f"{postgres_url}{'&' if '?' in postgres_url else '?'}options=-csearch_path%3Dprocesses"
    with closing(Database(postgres_url)) as first, first.engine.begin() as connection:
        connection.execute(text("DROP SCHEMA IF EXISTS processes CASCADE"))
        connection.execute(text("CREATE SCHEMA processes"))
    for url in (f"sqlite:///{tmp_path / 'balise.sqlite3'}", schema):
        command = [sys.executable, "-c", STARTS, url]
        pipes: dict[str, Any] = {"stdin": PIPE, "stdout": PIPE, "stderr": PIPE, "text": True, "cwd": ROOT}
        started = [Popen(command, **pipes) for _ in range(4)]
        for process in started:
            assert process.stdin is not None
            process.stdin.write("go\n")
            process.stdin.flush()
        said = [process.communicate(timeout=300) for process in started]
        assert [process.returncode for process in started] == [0] * 4, said
        assert sorted(out for out, _ in said) == ["", "", "", "migrated\n"]


def test_the_numbers_of_migrations_are_those_that_alembic_finds() -> None:
    scripts = ScriptDirectory.from_config(alembic_config())
    assert head_revision() == scripts.get_current_head()
    assert all(is_known_revision(script.revision) for script in scripts.walk_revisions())
    assert not is_known_revision("9999")


def test_what_is_current_needs_no_alembic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(migrated(Settings(data_dir=tmp_path))) as database:
        monkeypatch.setitem(sys.modules, "alembic", None)
        upgrade(database.engine)
        require_current_schema(database.engine)


def test_the_database_of_a_newer_version_is_refused_and_left_as_it_is(
    database: Database, both: Settings, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with database.write() as db:
        db.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    try:
        with pytest.raises(WrongSchemaError, match=rf"plus récente.*9999.*{head_revision()}"):
            upgrade(database.engine)
        if both.database_url:
            monkeypatch.setenv("BALISE_DATABASE_URL", both.database_url)
        assert main(["admin", "accounts", "--data", str(both.data_dir)]) == 2
        assert "plus récente" in capsys.readouterr().err
        with database.read() as db:
            assert db.execute(text("SELECT version_num FROM alembic_version")).scalar_one() == "9999"
    finally:
        with database.write() as db:
            db.execute(text("UPDATE alembic_version SET version_num = :head"), {"head": head_revision()})


def test_who_does_not_migrate_refuses_an_older_database(tmp_path: Path) -> None:
    with closing(Database(f"sqlite:///{tmp_path / 'balise.sqlite3'}")) as database:
        with pytest.raises(WrongSchemaError, match="absent"):
            require_current_schema(database.engine)
        upgrade(database.engine, "0001")
        with pytest.raises(WrongSchemaError, match=r"plus ancienne.*0001"):
            require_current_schema(database.engine)
