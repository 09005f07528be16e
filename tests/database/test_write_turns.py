"""Threads that write to a SQLite file get its lock in the order in which they asked for it."""

from __future__ import annotations

import sqlite3
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from server.database import write_turns
from server.database.write_turns import BEGIN_AND_LOCK, FairLock, begin_in_turn
from tests.support.live import until

WRITERS = 8


def connect(file: Path) -> sqlite3.Connection:
    return sqlite3.connect(file, isolation_level=None, check_same_thread=False)


def do_nothing() -> None:
    raise AssertionError("only an error is raised through SQLAlchemy")


def start(run: Callable[[], None]) -> threading.Thread:
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return thread


def test_nobody_is_overtaken(tmp_path: Path) -> None:
    turnstile, order = FairLock(), list[int]()
    holder = connect(tmp_path / "data.sqlite3")
    holder.execute(BEGIN_AND_LOCK)

    def write(number: int) -> None:
        connection = connect(tmp_path / "data.sqlite3")
        begin_in_turn(turnstile, connection, do_nothing)
        order.append(number)
        connection.execute("COMMIT")

    threads = []
    for number in range(WRITERS):
        threads.append(start(partial(write, number)))
        until(lambda: turnstile.is_taken and turnstile.waiting == len(threads) - 1, "one more waits")
    assert order == []
    holder.execute("COMMIT")
    for thread in threads:
        thread.join()
    assert order == list(range(WRITERS))
    assert not turnstile.is_taken


def test_a_lock_that_another_process_keeps_is_an_error_in_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(write_turns, "BUSY_TIMEOUT_SECONDS", 0.01)
    holder, other = (connect(tmp_path / "data.sqlite3") for _ in range(2))
    holder.execute(BEGIN_AND_LOCK)
    turnstile = FairLock()
    for _ in range(2):
        with pytest.raises(sqlite3.OperationalError, match="locked"):
            begin_in_turn(turnstile, other, lambda: other.execute(BEGIN_AND_LOCK))
    holder.execute("COMMIT")
    begin_in_turn(turnstile, other, do_nothing)
    assert other.in_transaction


def test_who_is_interrupted_leaves_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    turnstile = FairLock()

    class Interrupted(BaseException):
        """Raised by a signal."""

    class Gate:
        """A lock that a signal interrupts, as it is waited for the second time."""

        def __init__(self) -> None:
            self.asked = 0

        def acquire(self) -> None:
            self.asked += 1
            if self.asked == 2:
                raise Interrupted

        def release(self) -> None:
            raise AssertionError("nobody waits there any more")

    with turnstile:
        monkeypatch.setattr(threading, "Lock", Gate)
        with pytest.raises(Interrupted), turnstile:
            pass
        monkeypatch.undo()
        done: list[float] = []

        def pass_through() -> None:
            with turnstile:
                done.append(time.monotonic())

        thread = start(pass_through)
        until(lambda: turnstile.waiting == 1, "the next waits")
        assert not done
    thread.join()
    assert done
