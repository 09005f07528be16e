"""What many tests need and one process makes once: the course, an SQLite file at the current schema, a quick hasher."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Collection, Coroutine, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from unittest.mock import patch

import pytest

from server.base.settings import Settings
from tests.support.shipped import shipped_grader

if TYPE_CHECKING:
    from fastapi import FastAPI
    from pwdlib import PasswordHash

    from server.app import ApplicationServices
    from server.course import Course, Exercise
    from server.database import Database

T = TypeVar("T")


#: Of a figure: the light one is drawn in the fast suite.
THEMES = ["light", pytest.param("dark", marks=pytest.mark.slow)]


def some(values: Iterable[T]) -> list[T]:
    """These, of which there is at least one: a test that walks nothing proves nothing."""
    found = list(values)
    assert found, "there is nothing to walk through"
    return found


def one_in(count: int, cases: Iterable[Any]) -> list[Any]:
    """Parameters of a test: one in so many of these in the fast suite, the others among the slow tests."""
    return [case if k % count == 0 else _slow(case) for k, case in enumerate(some(cases))]


def only(chosen: Collection[Any], cases: Iterable[Any]) -> list[Any]:
    """Parameters of a test: those chosen in the fast suite, the others among the slow tests."""
    known = some(cases)
    assert all(case in known for case in chosen), "what is chosen is one of the cases"
    return [case if case in chosen else _slow(case) for case in known]


def _slow(case: Any) -> Any:
    return pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.slow)


@cache
def the_course() -> Course:
    """The real course, its texts left as they are, its graders of code steady (see `tests.support.reenactments`)."""
    from server.course import load_course

    course = load_course(render=False)
    modules = {name: replace(one, exercises=tuple(map(_steady, one.exercises))) for name, one in course.modules.items()}
    return replace(course, modules=modules)


def _steady(exercise: Exercise) -> Exercise:
    return replace(exercise, make=partial(shipped_grader, exercise.id)) if exercise.kind == "code" else exercise


def migrated(settings: Settings) -> Database:
    """A database at the current schema; a new one in an SQLite file is a copy of one that was migrated."""
    from server.database import Database

    if settings.database_url is None:
        path = Path(settings.sqlalchemy_url.removeprefix("sqlite:///"))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(_sqlite_file())
    else:
        _upgrade_once(settings.sqlalchemy_url)
    return Database(settings.sqlalchemy_url)


@cache
def _sqlite_file() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data_dir=Path(folder), workers=0)
        _upgrade_once(settings.sqlalchemy_url)
        left = [path.read_bytes() for path in Path(folder).iterdir()]
    assert len(left) == 1, "closing a database leaves one file"
    return left[0]


@cache
def _upgrade_once(url: str) -> None:
    from server.database import Database
    from server.database.migrate import upgrade

    database = Database(url)
    upgrade(database.engine)
    database.close()


@cache
def _services_without_chores() -> type[ApplicationServices]:
    """Services that ask the database nothing by themselves, neither as they start nor every few seconds.

    There is nothing to recover, and what a page asks is counted.
    """
    from server.app import ApplicationServices

    async def nothing(_services: ApplicationServices) -> None:
        return

    return type(
        "QuietServices",
        (ApplicationServices,),
        {"recover_and_clean_at_start": lambda _services: None, "recover_lost_jobs_periodically": nothing},
    )


_standing: dict[tuple[int, int, str], FastAPI] = {}


def standing_app(settings: Settings, course: Course) -> FastAPI:
    """An application whose routes this process puts together only once; it serves one test at a time.

    All that it holds is new: what it was built with, what runs while it serves, and nothing is overridden. It does not
    look for what was left behind.
    """
    from server.app import ROUTERS, create_app

    told = settings.body_bytes, settings.session_days, settings.root_path  # what its middleware was
    routers = () if told in _standing else ROUTERS
    with patch("server.app.ApplicationServices", _services_without_chores()), patch("server.app.ROUTERS", routers):
        new = create_app(settings, course=course)
    app = _standing.setdefault(told, new)
    app.state.provided = new.state.provided
    app.router.lifespan_context = new.router.lifespan_context
    app.dependency_overrides.clear()
    return app


@cache
def weak_hasher() -> PasswordHash:
    """Argon2id at its weakest, where a test is about something else than hashing."""
    from pwdlib import PasswordHash
    from pwdlib.hashers.argon2 import Argon2Hasher

    return PasswordHash((Argon2Hasher(time_cost=1, memory_cost=8, parallelism=1),))


def in_a_loop(scene: Coroutine[Any, Any, T]) -> T:
    """Runs it in a loop and a thread of its own: the browser's tests keep a loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, scene).result()
