"""Data that released versions wrote, upgraded on both engines: verdicts, sessions and tokens are those of then."""

from __future__ import annotations

import json
import lzma
import sqlite3
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import select

from server.backup.move import move_rows
from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from server.database.migrate import upgrade
from server.gradebook.models import Grading
from server.tables import metadata
from tests.support.client import TestClient
from tests.support.quick import standing_app

FOLDER = Path(__file__).parent / "released"


@dataclass(frozen=True)
class Released:
    """A file, with what its people hold since then."""

    schema: str
    sessions: dict[str, str]
    token: str

    def unpack(self, path: Path) -> Path:
        path.write_bytes(lzma.decompress((FOLDER / f"schema_{self.schema}.sqlite3.xz").read_bytes()))
        return path


RELEASED = (
    Released(
        "0003",
        {
            "student": "Zfi_9qRJTs5VyTol4bj_8GDDbW-MRKRItshD4YphkWU",
            "teacher": "VE0Zf9zUFEZoNv1svkLsMC3RDgsvIg7QQFcriQcC4m4",
            "guest": "bi_zB9czGAAxAXexPZOFx5kgPpG4Dmaa5U2DyZQsgNw",
        },
        "balise_1OqzMv9ZGl6y8G2o6uvQD7PKswmYycXO0b1LSkTRK1M",
    ),
)


def read_gradings(path: Path) -> dict[UUID, tuple[str, float, Any]]:
    """Read outcome, score and verdict of each grading, as the file has them."""
    with closing(sqlite3.connect(path)) as connection:
        rows = connection.execute("SELECT id, outcome, score, verdict FROM grading").fetchall()
    return {UUID(name): (outcome, score, json.loads(verdict)) for name, outcome, score, verdict in rows}


@pytest.fixture(params=RELEASED, ids=lambda released: released.schema)
def released(request: pytest.FixtureRequest) -> Released:
    found: Released = request.param
    return found


@pytest.fixture
def upgraded(released: Released, settings: Settings, database_url: str | None, tmp_path: Path) -> Settings:
    """Upgrade the file; on PostgreSQL, move it there."""
    file = released.unpack(tmp_path / "released.sqlite3")
    with closing(Database(f"sqlite:///{file}")) as source:
        upgrade(source.engine)
        if database_url is not None:
            with closing(Database(database_url)) as target:
                move_rows(source, target, metadata.sorted_tables, lambda _table, _rows: None)
    return settings.model_copy(update={"database_url": database_url or f"sqlite:///{file}"})


def test_marks_verdicts_sessions_and_tokens_are_those_of_then(
    released: Released, upgraded: Settings, course: Course, tmp_path: Path
) -> None:
    before = read_gradings(released.unpack(tmp_path / "original.sqlite3"))
    with closing(Database(upgraded.url)) as database, database.read() as db:
        after = {each.id: (each.outcome, each.score, each.verdict) for each in db.execute(select(Grading)).scalars()}
    assert before
    assert after == before
    app = standing_app(upgraded, course)
    with TestClient(app) as client:
        for person, cookie in released.sessions.items():
            cookies = {"Cookie": f"{SESSION_COOKIE}={cookie}"}
            for page in ("/", "/compte", "/l20", "/l20/exercices/poses", "/l20/exercices/poses/essais", "/classes"):
                answer = client.get(page, headers=cookies)
                assert answer.status_code == 200, (person, page)
                assert "Se connecter" not in answer.text or person == "guest", (person, page)
        attempts = client.get(
            "/l20/exercices/poses/essais", headers={"Cookie": f"{SESSION_COOKIE}={released.sessions['student']}"}
        )
        assert "20" in attempts.text
        bearer = {"Authorization": f"Bearer {released.token}"}
        last = client.get("/api/v1/me/exercises/l20/poses/last", headers=bearer)
        assert last.status_code == 200, last.text
        assert "def ramener" in last.json()["code"]
