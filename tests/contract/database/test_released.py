"""Data that released versions wrote, upgraded on both engines: marks, verdicts, sessions and tokens stay."""

from __future__ import annotations

import json
import lzma
import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import select

from server.backup.move import copy_rows_into_empty_database
from server.base.files import ROOT
from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from server.database.migrate import upgrade
from server.gradebook.models import Grading, Standing
from server.tables import metadata
from tests.support.client import TestClient
from tests.support.postgres import new_database
from tests.support.quick import standing_app

FOLDER = ROOT / "tests" / "database" / "released"
PAGES = ("/", "/compte", "/l20", "/l20/exercices/poses", "/l20/exercices/poses/essais", "/classes")
CLASS_PAGES = ("", "/tableau", "/carnet", "/eleves", "/devoirs", "/semaine", "/objectifs", "/journal", "/questions")
LOG_IN = "Se connecter"


@dataclass(frozen=True)
class Released:
    """A file, with what its people have: session cookies, or logins with passwords; a student's API token."""

    schema: str
    sessions: Mapping[str, str] = field(default_factory=dict)
    passwords: Mapping[str, str] = field(default_factory=dict)
    token: str = ""

    def unpack(self, path: Path) -> Path:
        path.write_bytes(lzma.decompress((FOLDER / f"schema_{self.schema}.sqlite3.xz").read_bytes()))
        return path


RELEASED = (
    Released(
        "0003",
        sessions={
            "student": "Zfi_9qRJTs5VyTol4bj_8GDDbW-MRKRItshD4YphkWU",
            "teacher": "VE0Zf9zUFEZoNv1svkLsMC3RDgsvIg7QQFcriQcC4m4",
            "guest": "bi_zB9czGAAxAXexPZOFx5kgPpG4Dmaa5U2DyZQsgNw",
        },
        token="balise_1OqzMv9ZGl6y8G2o6uvQD7PKswmYycXO0b1LSkTRK1M",
    ),
    Released("0021", passwords={"martin": "qfgXYNDsoXPV", "yasmine.chevalier": "UGdYCxIXkXie"}),
)


def read_file(path: Path) -> tuple[dict[UUID, Any], dict[tuple[UUID, str], Any], list[UUID]]:
    """Read the gradings, the standings and the classes of a file, as its own schema has them."""
    with closing(sqlite3.connect(path)) as connection:
        gradings = connection.execute("SELECT id, outcome, score, verdict FROM grading").fetchall()
        standings = connection.execute("SELECT account_id, exercise, best_score, attempts FROM standing").fetchall()
        is_with_classes = connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'school_class'").fetchone()
        classes = connection.execute("SELECT id FROM school_class").fetchall() if is_with_classes else []
    return (
        {UUID(name): (outcome, score, json.loads(verdict)) for name, outcome, score, verdict in gradings},
        {(UUID(account), exercise): (best, attempts) for account, exercise, best, attempts in standings},
        [UUID(name) for (name,) in classes],
    )


@dataclass(frozen=True)
class Upgraded:
    """A released file, and the address of its database at the current schema."""

    released: Released
    url: str


@pytest.fixture(
    scope="module",
    params=[(released, engine) for engine in ("sqlite", "postgresql") for released in RELEASED],
    ids=lambda param: f"{param[0].schema}-{param[1]}",
)
def upgraded(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Upgraded]:
    """Upgrade the file; on PostgreSQL, move it into a database of its own."""
    released, engine = request.param
    file = released.unpack(tmp_path_factory.mktemp("released") / "released.sqlite3")
    url = f"sqlite:///{file}"
    with closing(Database(url)) as source, ExitStack() as stack:
        upgrade(source.engine)
        if engine == "postgresql":
            server = request.getfixturevalue("postgres_url")
            url = stack.enter_context(new_database(server, f"balise_released_{os.getpid()}"))
            with closing(Database(url)) as target:
                copy_rows_into_empty_database(source, target, metadata.sorted_tables, lambda _table, _rows: None)
        yield Upgraded(released, url)


def test_verdicts_and_marks_are_those_of_then(upgraded: Upgraded, tmp_path: Path) -> None:
    gradings, standings, _ = read_file(upgraded.released.unpack(tmp_path / "original.sqlite3"))
    with closing(Database(upgraded.url)) as database, database.read() as db:
        after = {each.id: (each.outcome, each.score, each.verdict) for each in db.execute(select(Grading)).scalars()}
        best = {
            (each.account_id, each.exercise): (each.best_score, each.attempts)
            for each in db.execute(select(Standing)).scalars()
        }
    assert gradings
    assert after == gradings
    assert standings
    assert best == standings


def test_sessions_passwords_and_tokens_open_every_page(
    upgraded: Upgraded, settings: Settings, course: Course, tmp_path: Path
) -> None:
    released = upgraded.released
    _, _, classes = read_file(released.unpack(tmp_path / "original.sqlite3"))
    here = settings.model_copy(update={"database_url": upgraded.url})
    with TestClient(standing_app(here, course), follow_redirects=False) as client:
        for person, headers in enter(client, released):
            for page in PAGES:
                answer = client.get(page, headers=headers)
                assert answer.status_code == 200, (person, page)
                assert LOG_IN not in answer.text or person == "guest", (person, page)
            for school_class in classes if person == "martin" else ():
                for page in CLASS_PAGES:
                    answer = client.get(f"/classes/{school_class}{page}", headers=headers)
                    assert answer.status_code in {200, 303}, (page, answer.text)
        if released.token:
            bearer = {"Authorization": f"Bearer {released.token}"}
            last = client.get("/api/v1/me/exercises/l20/poses/last", headers=bearer)
            assert last.status_code == 200, last.text
            assert "def ramener" in last.json()["code"]


def enter(client: TestClient, released: Released) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield each person with the headers of their session."""
    for person, cookie in released.sessions.items():
        yield person, {"Cookie": f"{SESSION_COOKIE}={cookie}"}
    for login, password in released.passwords.items():
        client.cookies.clear()
        assert client.post("/connexion", data={"login": login, "password": password}).status_code == 303
        cookie = client.cookies[SESSION_COOKIE]
        client.cookies.clear()
        yield login, {"Cookie": f"{SESSION_COOKIE}={cookie}"}
