"""Fails a test in which slow work is done where others wait for it: while a transaction holds SQLite's write lock, or
on an event loop.

Slow is what takes milliseconds: a rendered page, a hashed password, coloured code, an archive, a list in a file. It is
done before the first statement of a writing transaction or after its end (`roll_back_then_read`, `commit_then_read`),
and in a thread.
"""

from __future__ import annotations

import asyncio
import csv
import sys
import zipfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from types import FrameType
from typing import Any

import jinja2
import pytest
from pwdlib import PasswordHash
from pygments.lexer import Lexer
from sqlalchemy.orm import Session

from server.database import Database, holds_write_lock

#: What is slow: its owner, its name there.
SLOW: tuple[tuple[Any, str], ...] = (
    (jinja2.Template, "render"),
    (PasswordHash, "hash"),
    (PasswordHash, "verify"),
    (Lexer, "get_tokens"),
    (zipfile.ZipFile, "__init__"),
    (csv, "reader"),
)

#: The writing sessions of a request, or of a thread.
_writing: ContextVar[tuple[list[Session], ...]] = ContextVar("writing", default=())


class SlowWorkError(Exception):
    """Others wait for this work."""


def _recording(write: Callable[[Database], AbstractContextManager[Session]]) -> Any:
    """Make `Database.write` record its session in the context of its caller: other threads enter and leave it."""

    def recorded(database: Database) -> AbstractContextManager[Session]:
        sessions: list[Session] = []
        _writing.set((*filter(None, _writing.get()), sessions))

        @contextmanager
        def opened() -> Iterator[Session]:
            with write(database) as db:
                sessions.append(db)
                try:
                    yield db
                finally:
                    sessions.clear()

        return opened()

    return recorded


def _guarded(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def guarded(*arguments: Any, **options: Any) -> Any:
        if any(holds_write_lock(db) for sessions in _writing.get() for db in sessions):
            raise SlowWorkError(f"{name} while the write lock is held")
        if _is_on_loop():
            raise SlowWorkError(f"{name} on an event loop")
        return function(*arguments, **options)

    return guarded


def _is_on_loop() -> bool:
    """Whether an event loop calls. That of a browser's test, in a greenlet of its own, is said to run all the time."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        if frame.f_code is asyncio.BaseEventLoop._run_once.__code__:  # type: ignore[attr-defined]
            return True
        frame = frame.f_back
    return False


@pytest.fixture(autouse=True, scope="session")
def _nobody_waits_for_slow_work() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Database, "write", _recording(Database.write))
        for owner, name in SLOW:
            patch.setattr(owner, name, _guarded(name, getattr(owner, name)))
        yield
