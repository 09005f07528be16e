"""What a submission asks of the database from its coming to its verdict: few statements, and a commit for each of its
three turns (stored, leased, recorded)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sqlalchemy import event

from server.base.settings import Settings
from server.course import Course
from server.database import Database
from tests.support.client import TestClient
from tests.support.counting import Counted
from tests.support.quick import standing_app
from tests.support.service import Site


def asked(database: Database, action: Callable[[], object]) -> tuple[int, int]:
    """Statements and commits that an action takes."""
    commits = 0

    def committed(_connection: Any) -> None:
        nonlocal commits
        commits += 1

    event.listen(database.engine, "commit", committed)
    try:
        with Counted(database) as counted:
            action()
    finally:
        event.remove(database.engine, "commit", committed)
    return len(counted.statements), commits


def test_from_a_submission_to_its_verdict_in_few_statements(database: Database, both: Settings, course: Course) -> None:
    app = standing_app(both, course)
    with TestClient(app, follow_redirects=False) as client:
        site = Site(app, client, both)
        headers = site.token()
        site.submit(headers)
        assert site.worker.run_one()
        postgresql = database.engine.dialect.name == "postgresql"
        # Who it is, and what their class asks; the allowance; the row; the classes, and when they were seen there; the
        # turn; the job, and its place. PostgreSQL takes a lock for the turn, where SQLite has one writer.
        assert asked(site.database, lambda: site.submit(headers)) == (9 + postgresql, 1)
        # The lease and the file; the job's end, the row, the verdict, what points to it, the standing. PostgreSQL tells
        # the time of the lease.
        assert asked(site.database, site.worker.run_one) == (7 + postgresql, 2)
