"""Rows of older schemas that a migration carries over: overrides and rules of marks, threads that were read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest
import sqlalchemy as sa
from sqlalchemy import select

from server.classes.models import SchoolClass
from server.comments.readers_repository import load_unread_threads
from server.database import Database, utc_now
from server.database.engine import writing_engine
from server.database.migrate import upgrade
from server.identity.models import Account
from server.marks.models import Override
from server.marks.repository import load_active_overrides, load_marking_rules
from server.marks.states import Counting, MarkingRules

BEFORE = "0024"
TIME, UUID_TYPE = sa.DateTime(timezone=True), sa.Uuid()
TYPES: dict[str, Any] = dict.fromkeys(("id", "class_id", "account_id"), UUID_TYPE)
TIMES = ("at", "created_at", "work_at", "changed_at", "staff_at", "seen_at")
TYPES |= {"based_on": sa.JSON(), **dict.fromkeys(TIMES, TIME)}


@pytest.fixture(params=["sqlite", "postgresql"])
def older(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Database]:
    url = f"sqlite:///{tmp_path / 'older.sqlite3'}"
    if request.param == "postgresql":
        base = request.getfixturevalue("postgres_url")
        engine = sa.create_engine(base, isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            connection.execute(sa.text("DROP SCHEMA IF EXISTS older_rows CASCADE"))
            connection.execute(sa.text("CREATE SCHEMA older_rows"))
        engine.dispose()
        url = f"{base}{'&' if '?' in base else '?'}options=-csearch_path%3Dolder_rows"
    with closing(Database(url)) as database:
        upgrade(database.engine, BEFORE)
        yield database


def insert(connection: sa.Connection, table: str, **values: Any) -> None:
    columns = [sa.column(name, TYPES.get(name)) for name in values]
    connection.execute(sa.insert(sa.table(table, *columns)).values(values))


def test_an_older_class_keeps_its_numbers_and_its_overrides(older: Database) -> None:
    account_id, class_id, override_id = uuid4(), uuid4(), uuid4()
    with writing_engine(older.engine).begin() as connection:
        now = utc_now()
        insert(connection, "account", id=account_id, role="student", name="Ada", created_at=now)
        insert(connection, "school_class", id=class_id, name="MPSI", module="l20", created_at=now, approval=False)
        insert(
            connection, "mark_override", id=override_id, class_id=class_id, account_id=account_id, exercise="l20/poses",
            points=12.0, excused=False, reason="oral", based_on=[None], at=now,
        )  # fmt: skip
    upgrade(older.engine)
    with older.write() as db:
        marking = load_marking_rules(db, class_id)
        assert (marking.rules, marking.is_chosen) == (MarkingRules(*[Counting.zero] * 4), False)
        new = SchoolClass(name="PSI", module="l20")
        db.add(new)
        db.flush()
        assert (load_marking_rules(db, new.id).rules, load_marking_rules(db, new.id).is_chosen) == (
            MarkingRules(),
            True,
        )
        assert db.execute(select(Override.id, Override.assignment_id)).all() == [(override_id, None)]
        ((_, exercise, scope),) = load_active_overrides(db, class_id)
        assert (exercise, scope) == ("l20/poses", None)
        assert db.get(Account, account_id) is not None


def test_a_thread_that_its_student_has_read_stays_read(older: Database) -> None:
    account_id, read, unread, now = uuid4(), uuid4(), uuid4(), utc_now()
    with writing_engine(older.engine).begin() as connection:
        insert(connection, "account", id=account_id, role="student", name="Ada", created_at=now)
        for thread, seen_at in ((read, now), (unread, now - timedelta(minutes=1))):
            insert(
                connection, "thread", id=thread, account_id=account_id, exercise="l20/poses", work_at=now,
                by_staff=True, check_title="", state="answered", created_at=now, changed_at=now, staff_at=now,
                seen_at=seen_at,
            )  # fmt: skip
    upgrade(older.engine)
    with older.read() as db:
        assert [row.thread.id for row in load_unread_threads(db, account_id)] == [unread]
