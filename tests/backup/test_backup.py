"""Backups: whole under load, checked, and refused where they are not what they say."""

from __future__ import annotations

import errno
import json
import shutil
import sqlite3
import stat
import threading
import zipfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any
from uuid import UUID

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import select, text, update

from server.backup import service
from server.backup.archive import MANIFEST, BackupError
from server.backup.foreign import unescape_copy_field
from server.backup.move import compute_table_digest
from server.base.settings import Settings
from server.cli import main
from server.cli.data_lock import lock_data_folder
from server.database import END_OF_TIME, Database, utc_now
from server.database.migrate import (
    WrongSchemaError,
    alembic_config,
    missing_migrations,
    require_current_schema,
    upgrade,
)
from server.gradebook.models import Grading
from server.identity.models import Account
from server.queue.models import Job
from server.submissions.models import Submission
from server.submissions.service import SubmissionService
from server.tables import TABLE_NAMES, metadata
from tests.support.crowd import Sent, store
from tests.support.service import EXERCISE, QUIET, new_account, worker_of

#: What COPY, JSON and SQLite each have a way of their own to write.
TABLES = metadata.sorted_tables
AWKWARD = "é ’\t\\N \\ \" ' $$ \r\n \u2028 𝔸"


@contextmanager
def busy(database: Database, settings: Settings, writers: int = 3) -> Iterator[dict[UUID, bytes]]:
    """Students who send without pause, and a worker that grades; what was acknowledged so far, while it goes on."""
    acknowledged: dict[UUID, bytes] = {}
    over = threading.Event()
    store = SubmissionService(
        settings.model_copy(update={"submission_refill_seconds": 0, "waiting_each": 10**6}), QUIET
    )
    started = threading.Barrier(writers + 2)

    def send(account: Account) -> None:
        started.wait()
        number = 0
        while not over.is_set():
            number += 1
            code = f"# {AWKWARD} {account.id} {number}"
            with database.write() as db:
                made = store.submit(db, account, EXERCISE, code, address="192.0.2.1")
            acknowledged[made.id] = code.encode()

    def grade() -> None:
        worker = worker_of(database, settings)
        started.wait()
        while not over.is_set():
            worker.run_one()

    accounts = [new_account(database, name=f"{AWKWARD} {number}"[:90]) for number in range(writers)]
    threads = [threading.Thread(target=send, args=(account,)) for account in accounts] + [
        threading.Thread(target=grade)
    ]
    for thread in threads:
        thread.start()
    try:
        started.wait()
        while len(acknowledged) < 10:
            over.wait(0.01)
        yield acknowledged
    finally:
        over.set()
        for thread in threads:
            thread.join()


def test_what_was_acknowledged_before_a_backup_under_load_is_restored(
    database: Database, both: Settings, tmp_path: Path
) -> None:
    file = tmp_path / "save.zip"
    with busy(database, both) as acknowledged:
        before = dict(acknowledged)
        manifest = service.back_up(both, file, TABLE_NAMES)
        while len(acknowledged) < len(before) + 5:
            threading.Event().wait(0.01)
    database.close()
    restored, kept = service.restore_backup(both, file, TABLES, replace=True, now=utc_now())
    assert restored == manifest
    again = Database(both.sqlalchemy_url)
    with again.read() as db:
        found = {row[0]: row[1] for row in db.execute(select(Submission.id, Submission.source))}
        waiting = {UUID(key) for key in db.execute(select(Job.key)).scalars()}
        graded = set(db.execute(select(Grading.submission_id)).scalars())
        names = db.execute(select(Account.name)).scalars().all()
    again.close()
    assert before.items() <= found.items() <= acknowledged.items()
    assert len(found) < len(acknowledged), "the service had gone on"
    assert waiting | graded == found.keys(), "each is graded, or waits"
    assert not waiting & graded
    assert len(names) == 3
    assert (kept is not None) == both.sqlalchemy_url.startswith("sqlite")


def test_revisions_are_what_they_were_and_are_drawn_anew_again(
    database: Database, both: Settings, tmp_path: Path
) -> None:
    ada = new_account(database)

    def told(database: Database) -> tuple[object, ...]:
        with database.read() as db:
            return tuple(db.execute(select(Submission.revision, Submission.grading_id)).one())

    (graded,) = store(database, [Sent(ada.id, EXERCISE, utc_now(), 0.5)])
    before = told(database)
    file = tmp_path / "save.zip"
    service.back_up(both, file, TABLE_NAMES)
    with database.write() as db:
        db.execute(update(Grading).where(Grading.submission_id == graded).values(score=1.0))
    assert told(database) != before
    database.close()
    service.restore_backup(both, file, TABLES, replace=True, now=utc_now())
    again = Database(both.sqlalchemy_url)
    assert told(again) == before
    with again.write() as db:
        db.execute(update(Grading).where(Grading.submission_id == graded).values(score=1.0))
    after = told(again)
    again.close()
    assert after[0] not in {None, before[0]}


#: What the test under load tries on PostgreSQL too is tried there alone among the slow ones.
MOSTLY_SQLITE = pytest.mark.parametrize(
    "database_url", ["sqlite", pytest.param("postgresql", marks=pytest.mark.slow)], indirect=True
)


@MOSTLY_SQLITE
def test_a_backup_says_how_many_rows_there_are_of_what(database: Database, both: Settings, tmp_path: Path) -> None:
    new_account(database)
    first = service.back_up(both, tmp_path / "1.zip", TABLE_NAMES)
    assert {name for name, saved in first.tables.items() if saved.rows} == {"account", "alembic_version"}
    assert first.tables.keys() == TABLE_NAMES | {"alembic_version"}
    if both.sqlalchemy_url.startswith("sqlite"):
        assert service.verify_backup(both, tmp_path / "1.zip") == first
    with database.write() as db:
        db.execute(text("UPDATE account SET name = 'Eve'"))
    changed = service.back_up(both, tmp_path / "2.zip", TABLE_NAMES)
    assert changed.find_differing_tables(first.tables) == ["account"], "and all else is what it was"
    assert stat.S_IMODE((tmp_path / "2.zip").stat().st_mode) == 0o600
    assert sorted(path.name for path in tmp_path.glob("*.zip*")) == ["1.zip", "2.zip"], "nothing half written"


def test_no_table_counts_by_itself(database: Database) -> None:
    """A sequence would have to be restored too."""
    if database.engine.dialect.name == "postgresql":
        with database.read() as db:
            assert db.execute(text("SELECT count(*) FROM pg_sequences")).scalar_one() == 0


def altered(file: Path, made: Path, member: str, change: Any) -> Path:
    """The same archive, with one of its members changed."""
    with zipfile.ZipFile(file) as old, zipfile.ZipFile(made, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            new.writestr(name, change(content) if name == member else content)
    return made


@MOSTLY_SQLITE
def test_a_damaged_backup_changes_nothing(database: Database, both: Settings, tmp_path: Path) -> None:
    ada = new_account(database, name="Ada Lovelace")
    file = tmp_path / "save.zip"
    service.back_up(both, file, TABLE_NAMES)
    data = "balise.sqlite3" if both.sqlalchemy_url.startswith("sqlite") else "tables/account.copy"
    (tmp_path / "cut.zip").write_bytes(file.read_bytes()[:-30])
    (tmp_path / "text.zip").write_text("bonjour")
    damaged = [
        altered(file, tmp_path / "row.zip", data, lambda content: content.replace(b"Ada Lovelace", b"Eve Lovelace")),
        altered(file, tmp_path / "count.zip", MANIFEST, lambda text: text.replace(b'"rows": 1', b'"rows": 2')),
        altered(file, tmp_path / "short.zip", data, lambda content: content[: len(content) // 2]),
        tmp_path / "cut.zip",
        tmp_path / "text.zip",
        tmp_path / "absent.zip",
    ]
    for path in damaged:
        with pytest.raises(BackupError):
            service.restore_backup(both, path, TABLES, replace=True, now=utc_now())
    newer = altered(file, tmp_path / "newer.zip", MANIFEST, _from_the_future)
    with pytest.raises(BackupError, match="plus récente"):
        service.verify_backup(both, newer)
    with pytest.raises(BackupError, match="--replace"):
        service.restore_backup(both, file, TABLES, replace=False, now=utc_now())
    with database.read() as db:
        assert db.execute(select(Account.id)).scalars().all() == [ada.id]


def _from_the_future(manifest: bytes) -> bytes:
    return json.dumps({**json.loads(manifest), "revision": "9999"}).encode()


def rows_as_stored(database: Database) -> dict[str, Any]:
    with database.engine.connect() as connection:
        return {table.name: compute_table_digest(connection, table) for table in TABLES}


@pytest.mark.parametrize("database_url", ["sqlite", "postgresql"], indirect=True)
def test_a_backup_is_restored_into_the_other_engine(
    database: Database, both: Settings, tmp_path: Path, postgres_url: str
) -> None:
    accounts = [new_account(database, name=f"{AWKWARD} {number}") for number in range(3)]
    first, *_ = store(database, [Sent(account.id, EXERCISE, utc_now(), 0.5) for account in accounts])
    with database.write() as db:
        source = AWKWARD.encode() + b"\x00\\xff"
        db.execute(update(Submission).where(Submission.id == first).values(source=source, created_at=END_OF_TIME))
        db.execute(update(Grading).where(Grading.submission_id == first).values(figures={AWKWARD: [1e-320, 0.1]}))
    before = rows_as_stored(database)
    file = tmp_path / "save.zip"
    service.back_up(both, file, TABLE_NAMES)
    is_local = database.is_local_file
    url = postgres_url if is_local else f"sqlite:///{tmp_path}/other.sqlite3"
    other = both.model_copy(update={"database_url": url})
    assert service.verify_backup(other, file).row_count
    service.restore_backup(other, file, TABLES, replace=is_local, now=utc_now())
    with closing(Database(other.sqlalchemy_url)) as restored:
        assert rows_as_stored(restored) == before
        require_current_schema(restored.engine)
        with restored.write() as db:
            db.execute(Account.__table__.delete())
    member = "balise.sqlite3" if is_local else "tables/account.copy"
    damaged = altered(file, tmp_path / "damaged.zip", member, lambda content: content.replace(b" 1", b" 7"))
    with pytest.raises(BackupError, match="abîmée"):
        service.restore_backup(other, damaged, TABLES, replace=True, now=utc_now())


@given(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0")))
def test_a_field_of_copy_is_read_as_it_was_written(value: str) -> None:
    written = value.replace("\\", "\\\\")
    for character, letter in (("\b", "b"), ("\f", "f"), ("\n", "n"), ("\r", "r"), ("\t", "t"), ("\v", "v")):
        written = written.replace(character, f"\\{letter}")
    assert unescape_copy_field(written) == value


def test_the_commands_save_and_restore_beside_what_was_there(
    sqlite: Database, settings: Settings, tmp_path: Path, capsys: Any
) -> None:
    new_account(sqlite)
    data = ["--data", str(settings.data_dir)]
    assert main(["backup", str(tmp_path), *data]) == 0
    (file,) = tmp_path.glob("balise-*.zip")
    said = capsys.readouterr().out
    assert str(file) in said
    assert "vérifiée" in said
    assert main(["backup", str(file), *data]) == 2
    assert main(["restore", str(file), *data]) == 2
    assert "--replace" in capsys.readouterr().err
    assert main(["restore", str(file), "--check", "--json", *data]) == 0
    assert json.loads(capsys.readouterr().out)["tables"]["account"]["rows"] == 1
    new_account(sqlite)
    sqlite.close()
    assert main(["restore", str(file), "--replace", *data]) == 0
    (kept,) = settings.data_dir.glob("balise.sqlite3.avant-????????-??????")
    for path, count in ((settings.data_dir / "balise.sqlite3", 1), (kept, 2)):
        assert sqlite3.connect(path).execute("SELECT count(*) FROM account").fetchone() == (count,)
    shutil.rmtree(settings.data_dir)
    assert main(["restore", str(file), *data]) == 0, "to a new machine"
    migrated_one = Database(settings.sqlalchemy_url)
    with migrated_one.read() as db:
        assert len(db.execute(select(Account.id)).all()) == 1
    migrated_one.close()
    assert main(["backup", "--data", str(tmp_path / "elsewhere")]) == 2


def test_a_restoration_waits_for_the_service_to_be_stopped(
    sqlite: Database, settings: Settings, tmp_path: Path, capsys: Any
) -> None:
    data = ["--data", str(settings.data_dir)]
    assert main(["backup", str(tmp_path / "save.zip"), *data]) == 0
    with lock_data_folder(settings):
        assert main(["restore", str(tmp_path / "save.zip"), "--replace", *data]) == 2
    assert "un autre serveur" in capsys.readouterr().err


def test_what_is_no_database_of_ours_is_not_saved(settings: Settings, tmp_path: Path) -> None:
    settings.data_dir.mkdir(parents=True)
    sqlite3.connect(settings.data_dir / "balise.sqlite3").execute("CREATE TABLE other (x)").connection.close()
    with pytest.raises(BackupError, match="rien n’est sauvegardé"):
        service.back_up(settings, tmp_path / "save.zip", TABLE_NAMES)
    assert not [path for path in tmp_path.iterdir() if path != settings.data_dir]


def test_an_older_backup_comes_to_the_current_schema(settings: Settings, tmp_path: Path) -> None:
    old = Database(settings.sqlalchemy_url)
    upgrade(old.engine, "0016")
    old.close()
    assert service.back_up(settings, tmp_path / "old.zip", TABLE_NAMES).revision == "0016"
    service.restore_backup(settings, tmp_path / "old.zip", TABLES, replace=True, now=utc_now())
    now = Database(settings.sqlalchemy_url)
    require_current_schema(now.engine)
    now.close()


def test_a_database_is_saved_before_its_schema_changes(
    database: Database, both: Settings, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert service.back_up_before_upgrade(both, database, TABLE_NAMES, utc_now()) is None, "nothing is missing"
    old = both.model_copy(update={"data_dir": tmp_path / "old", "upgrade_backup_dir": tmp_path})
    with closing(Database(old.sqlalchemy_url)) as older:
        if older.is_local_file:
            upgrade(older.engine, "0016")
        else:
            from alembic import command

            with older.engine.begin() as connection:
                command.downgrade(alembic_config(connection), "0029")
        copy = service.back_up_before_upgrade(old, older, TABLE_NAMES, utc_now())
        assert copy is not None
        assert str(copy) in caplog.text, "the administrator reads where"
        assert stat.S_IMODE(copy.stat().st_mode) == 0o600
        if older.is_local_file:
            with closing(Database(f"sqlite:///{copy}")) as saved, pytest.raises(WrongSchemaError, match="0016"):
                require_current_schema(saved.engine)
        else:
            assert service.verify_backup(old, copy).revision == "0029"
            unset = old.model_copy(update={"upgrade_backup_dir": None})
            assert service.back_up_before_upgrade(unset, older, TABLE_NAMES, utc_now()) is None
            assert "without a safety copy" in caplog.text
        upgrade(older.engine)
        assert service.back_up_before_upgrade(old, older, TABLE_NAMES, utc_now()) is None


def test_a_copy_that_does_not_fit_changes_nothing(settings: Settings, monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(Database(settings.sqlalchemy_url)) as older:
        upgrade(older.engine, "0016")
        monkeypatch.setattr(Path, "touch", _disk_is_full)
        with pytest.raises(BackupError, match="No space left"):
            service.back_up_before_upgrade(settings, older, TABLE_NAMES, utc_now())
        assert missing_migrations(older.engine) == "0016"
    assert not list(settings.data_dir.glob("*.avant-*"))


def _disk_is_full(_path: Path, *_: object, **__: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")
