"""Migrations, transactions and times, on both databases."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta, timezone

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import select

from server.database import Database, after_commit
from server.database.migrate import upgrade
from server.identity.models import Account
from server.limits.models import Allowance
from server.tables import metadata


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
            after_commit(db, lambda: ran.append("told"))
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
        after_commit(db, look)
    assert seen == [1]


def test_concurrent_read_modify_write_loses_nothing(database: Database) -> None:
    with database.write() as db:
        db.add(Allowance(key="k", tokens=0, updated_at=datetime.now(UTC)))

    def increment(_: int) -> None:
        with database.write() as db:
            row = db.execute(select(Allowance).where(Allowance.key == "k").with_for_update()).scalar_one()
            row.tokens += 1

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(increment, range(80)))
    with database.read() as db:
        assert db.execute(select(Allowance.tokens)).scalar_one() == 80


def test_times_come_back_aware_and_equal(database: Database) -> None:
    noon = datetime(2026, 3, 1, 12, tzinfo=timezone(timedelta(hours=5)))
    with database.write() as db:
        db.add(Account(name="Ada", created_at=noon))
    with database.read() as db:
        read = db.execute(select(Account.created_at)).scalar_one()
    assert read == noon
    assert read.utcoffset() == timedelta(0)
