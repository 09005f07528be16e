"""What is slow to start, and which all the processes of xdist may use at once: one of them keeps it for all."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import pytest


@contextmanager
def shared(
    factory: pytest.TempPathFactory, name: str, start: Callable[[Path], AbstractContextManager[str]]
) -> Iterator[str]:
    """What `start` yields, from this process or from the one that started it first.

    `start` is given a folder that is nobody else's. Who started it ends it, once nobody uses it any more.
    """
    folder = factory.getbasetemp().parent if "PYTEST_XDIST_WORKER" in os.environ else factory.getbasetemp()
    told = folder / f"{name}.told"
    with (folder / f"{name}.lock").open("a") as lock, (folder / f"{name}.users").open("a") as users:
        fcntl.flock(lock, fcntl.LOCK_EX)
        fcntl.flock(users, fcntl.LOCK_SH)
        if told.exists():
            fcntl.flock(lock, fcntl.LOCK_UN)
            yield told.read_text()
            return
        with start(factory.mktemp(name)) as what:
            told.write_text(what)
            fcntl.flock(lock, fcntl.LOCK_UN)
            yield what
            fcntl.flock(users, fcntl.LOCK_UN)
            fcntl.flock(users, fcntl.LOCK_EX)  # the others have ended, or wait for the lock below
            told.unlink()
