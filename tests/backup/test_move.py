"""Moves between engines: every row arrives as it was, and nothing else changes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Table, select, text, update

from server.backup.archive import BackupError
from server.backup.move import compute_table_digest, copy_rows_into_empty_database
from server.base.settings import Settings
from server.cli import main
from server.cli.data_lock import lock_data_folder
from server.database import Database, utc_now
from server.gradebook.models import Grading
from server.identity.models import Account
from server.submissions.models import Submission
from server.tables import metadata
from tests.support.crowd import Sent, store
from tests.support.service import EXERCISE, new_account, opened

AWKWARD = "é ’\t\\N \\ \" ' $$ \r\n \u2028 𝔸"
TABLES: list[Table] = metadata.sorted_tables


@pytest.fixture
def postgres(settings: Settings, postgres_url: str) -> Iterator[Database]:
    yield from opened(settings.model_copy(update={"database_url": postgres_url}))


def fill(database: Database) -> None:
    """Write accounts and gradings that have what each engine stores in a way of its own."""
    accounts = [new_account(database, name=f"{AWKWARD} {number}") for number in range(3)]
    sent = [Sent(account.id, EXERCISE, utc_now(), score) for account in accounts for score in (0.1, 1.0)]
    first, *_ = store(database, sent)
    with database.write() as db:
        db.execute(update(Submission).where(Submission.id == first).values(source=AWKWARD.encode() + b"\x00\xff"))
        db.execute(update(Grading).where(Grading.submission_id == first).values(figures={"é": [1e-320, 0.1, None]}))


def digests(database: Database) -> dict[str, Any]:
    with database.engine.connect() as connection:
        return {table.name: compute_table_digest(connection, table) for table in TABLES}


def discard(_table: str, _rows: int) -> None:
    pass


def move(source: Database, target: Database) -> None:
    """Without a connection in the pool, which would be somebody who uses the source."""
    source.engine.dispose()
    copy_rows_into_empty_database(source, target, TABLES, discard)


def test_rows_go_to_postgresql_and_back_as_they_were(sqlite: Database, postgres: Database, tmp_path: Path) -> None:
    fill(sqlite)
    before = digests(sqlite)
    move(sqlite, postgres)
    assert digests(postgres) == before == digests(sqlite)
    with closing(Database(f"sqlite:///{tmp_path}/again.sqlite3")) as again:
        move(postgres, again)
        assert digests(again) == before
        with again.write() as db:
            revision = db.execute(select(Submission.revision).limit(1)).scalar_one()
            db.execute(update(Grading).values(score=0.5))
            assert db.execute(select(Submission.revision).limit(1)).scalar_one() != revision, "triggers work again"
            assert not db.execute(text("PRAGMA foreign_key_check")).all()


def test_foreign_keys_hold_after_a_move_to_postgresql(sqlite: Database, postgres: Database) -> None:
    fill(sqlite)
    move(sqlite, postgres)
    with postgres.write() as db:
        revision = db.execute(select(Submission.revision).order_by(Submission.id).limit(1)).scalar_one()
        db.execute(update(Grading).values(score=0.5))
        assert db.execute(select(Submission.revision).order_by(Submission.id).limit(1)).scalar_one() != revision
        db.execute(Account.__table__.delete())
        assert not db.execute(select(Grading.id)).all(), "what is theirs goes with them"


def test_a_target_that_is_used_is_refused_and_stays_as_it_was(sqlite: Database, postgres: Database) -> None:
    fill(sqlite)
    new_account(postgres, name="Eve")
    before = digests(postgres)
    with pytest.raises(BackupError, match="sert déjà"):
        move(sqlite, postgres)
    assert digests(postgres) == before


def test_a_source_that_somebody_uses_is_refused(postgres: Database, tmp_path: Path) -> None:
    new_account(postgres)
    source = Database(postgres.engine.url.render_as_string(hide_password=False))
    target = Database(f"sqlite:///{tmp_path}/new.sqlite3")
    with closing(source), closing(target), postgres.engine.connect(), pytest.raises(BackupError, match="sert encore"):
        move(source, target)


def test_what_the_other_engine_cannot_hold_is_said_with_its_table(sqlite: Database, postgres: Database) -> None:
    account = new_account(sqlite)
    with sqlite.write() as db:
        db.execute(update(Account).where(Account.id == account.id).values(name="a\x00b"))
    with pytest.raises(BackupError, match="la table account ne se copie pas"):
        move(sqlite, postgres)
    assert not digests(postgres)["account"].rows


def test_the_command_moves_between_folders(
    sqlite: Database, settings: Settings, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fill(sqlite)
    before = digests(sqlite)
    sqlite.close()
    folders = [str(settings.data_dir), str(tmp_path / "nouveau")]
    with lock_data_folder(settings):
        assert main(["move", *folders]) == 2
    assert "un autre serveur" in capsys.readouterr().err
    assert main(["move", *folders, "--json"]) == 0
    out = capsys.readouterr()
    assert json.loads(out.out)["tables"]["submission"] == 6
    assert "submission : 6 lignes" in out.err
    with closing(Database(f"sqlite:///{tmp_path}/nouveau/balise.sqlite3")) as moved:
        after = digests(moved)
        assert [table for table in before if after[table] != before[table]] == ["audit_event"]
        assert after["audit_event"].rows == before["audit_event"].rows + 1, "the move is logged"
    assert main(["move", *folders]) == 2
    assert "sert déjà" in capsys.readouterr().err
    assert main(["move", folders[0], folders[0]]) == 2
    assert main(["move", str(tmp_path / "absent"), folders[1]]) == 2
