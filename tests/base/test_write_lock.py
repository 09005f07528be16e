"""The guard of all tests: slow work fails while the write lock is held, and on an event loop."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from jinja2 import Template
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from server.database import Database, commit_then_read, roll_back_then_read, run_after_commit
from server.identity.models import Account, Role
from tests.support.quick import in_a_loop
from tests.support.write_lock import SlowWorkError

PAGE = Template("page")


def _people(database: Database) -> int:
    with database.read() as db:
        return db.execute(select(func.count()).select_from(Account)).scalar_one()


def test_slow_work_fails_while_the_write_lock_is_held(database: Database) -> None:
    with database.write() as db:
        assert PAGE.render() == "page", "nothing is locked yet"
        db.add(Account(name="A", role=Role.guest))
        db.flush()
        with pytest.raises(SlowWorkError, match="write lock"):
            PAGE.render()
    assert PAGE.render() == "page"


def test_slow_work_fails_on_an_event_loop() -> None:
    async def render() -> str:
        return PAGE.render()

    with pytest.raises(SlowWorkError, match="event loop"):
        in_a_loop(render())


@pytest.mark.parametrize(("end", "count"), [(commit_then_read, 1), (roll_back_then_read, 0)])
def test_a_writing_session_that_reads_from_then_on(
    database: Database, end: Callable[[Session], None], count: int
) -> None:
    before, committed = _people(database), list[bool]()
    with database.write() as db:
        db.add(Account(name="A", role=Role.guest))
        db.flush()
        run_after_commit(db, lambda: committed.append(True))
        end(db)
        assert len(committed) == count
        assert len(db.scalars(select(Account)).all()) == before + count
        assert PAGE.render() == "page"
        with database.write() as other:  # waits for nobody
            other.add(Account(name="B", role=Role.guest))
    assert _people(database) == before + count + 1
    assert len(committed) == count
