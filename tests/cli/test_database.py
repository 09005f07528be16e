"""The database of a command."""

from __future__ import annotations

from contextlib import closing

import pytest

from server.base.settings import Settings
from server.cli import CommandError
from server.cli import database as commands
from server.database import Database
from server.database.migrate import require_current_schema, upgrade


def test_a_worker_waits_until_the_schema_is_upgraded(settings: Settings, monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(Database(settings.sqlalchemy_url)) as older:
        upgrade(older.engine, "0016")
    with pytest.raises(CommandError, match="plus ancienne"), commands.open_database(settings):
        pass
    waits: list[float] = []

    def wait(seconds: float) -> None:
        waits.append(seconds)
        with closing(Database(settings.sqlalchemy_url)) as migrated:
            upgrade(migrated.engine, "0020" if len(waits) == 1 else "head")

    monkeypatch.setattr(commands, "sleep", wait)  # not that of other threads
    with commands.open_database(settings, await_schema=True) as database:
        require_current_schema(database.engine)
    assert len(waits) == 2
