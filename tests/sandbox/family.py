"""The processes of a test's own sandboxes, seen from outside."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import TypeVar

from server.sandbox import Sandbox, WallReport, probe
from server.sandbox.process import TemplateProcess

T = TypeVar("T")
SOURCE = b"def f(x):\n    return x + 1\n"
LEAVES = b"import os\nos._exit(1)\n"


def answers(sandbox: Sandbox) -> None:
    """It runs an honest program."""
    with sandbox.open(SOURCE) as session:
        assert session.call("f", 1).value == 2


@cache
def probed() -> dict[str, WallReport]:
    """The walls of this machine, without those that must be waited for."""
    return {report.name: report for report in probe(slow=False)}


def descendants(root: int) -> set[int]:
    """The living processes that a process has started, and those that they have started."""
    parents = {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            state, parent = Path(f"/proc/{name}/stat").read_text().rpartition(")")[2].split()[:2]
            if state != "Z":
                parents[int(name)] = int(parent)
    found, generation = set(), {root}
    while generation:
        generation = {pid for pid, parent in parents.items() if parent in generation} - OTHERS
        found |= generation
    return found


#: What the sandbox of other tests has left running in this process.
OTHERS: set[int] = set()
#: The sandboxes of this process that many tests share, and that make spare children ready after a session.
SHARED: list[Sandbox] = []


def settle() -> None:
    """Returns when the shared sandboxes have made ready what their last sessions left to do."""
    for sandbox in SHARED:
        for executor in (sandbox._refiller, sandbox._renewer):
            executor.submit(int).result()


def children(pid: int) -> list[int]:
    below = Path(f"/proc/{pid}/task").glob("*/children")
    return [int(child) for thread in below for child in thread.read_text().split()]


def told_by_living(pids: Iterable[int], tell: Callable[[int], T]) -> list[T]:
    """What each process tells, without those that end just now: a fork of the test before may."""
    told = []
    for pid in pids:
        with contextlib.suppress(OSError):
            told.append(tell(pid))
    return told


def templates() -> set[int]:
    """The processes of the test's own sandboxes."""
    return descendants(os.getpid())


def root_and_template() -> tuple[int, int]:
    """The process that the test's only sandbox has started, and its child: the template."""
    (watcher,) = set(children(os.getpid())) - OTHERS
    (template,) = children(watcher)
    return watcher, template


def template_of(sandbox: Sandbox, imports: str = "numpy") -> TemplateProcess:
    """The one that serves an import set, started where there is none."""
    sandbox.warm(imports)
    template = sandbox._slots[imports].template
    assert template
    return template


def running(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def eventually(condition: Callable[[], bool], seconds: float = 120.0) -> bool:
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True
