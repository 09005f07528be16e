"""Many submissions, a quarter of them hostile, templates that wear out, are killed or hang: nothing is left."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from server.sandbox import FaultKind, Policy, ProgramFault, Sandbox, SandboxFault
from server.sandbox.cgroups import usable_hierarchies
from server.sandbox.child.namespaces import UNPRIVILEGED
from tests.sandbox.family import OTHERS, children, eventually, running, settle, templates
from tests.sandbox.limits import only

pytestmark = pytest.mark.usefixtures("alone")

SUBMISSIONS = int(os.environ.get("BALISE_TEST_SUBMISSIONS", "2000"))
FEWER = 150
SEED = int(os.environ.get("BALISE_TEST_SEED", "3"))
THREADS = 4
#: As many times as a worker grades.
TRIES = 2
POLICY = only(memory_bytes=64 << 20)
HURRIED = only(wall_seconds=0.1, memory_bytes=64 << 20)
#: The user and creator of a System V segment. Only where the sandbox has a user of its own can one be told to be its.
OWNERS = slice(7, 11)
MARK = f"balise-reste-{os.getpid()}"

HONEST = b"import numpy as np\ndef f(x):\n    return float(np.sum(np.arange(x)))\n"
FORGED = """
import os, struct
def f(x):
    frame = struct.pack("<IQB", 8, 7, 3) + b"12345678"
    for number in range(1024):
        try:
            os.write(number, frame)
        except OSError:
            pass
"""
LEAVES_THINGS = f"""
import mmap, os
kept = []
def f(x):
    kept.append(mmap.mmap(-1, 1 << 20))
    for folder in ("/dev/shm", "/tmp", ".", "/home/eleve"):
        try:
            kept.append(open(folder + "/{MARK}", "w"))
        except OSError:
            pass
    return float(sum(range(x)))
"""
#: What a hostile program gets; None for its own right answer.
HOSTILE: list[tuple[str, FaultKind | None]] = [
    ("def f(x): raise ValueError(x)", FaultKind.RUNTIME_ERROR),
    ("import sys\ndef f(x): sys.exit(0)", FaultKind.RUNTIME_ERROR),
    ("import os\ndef f(x): os._exit(3)", FaultKind.RUNTIME_ERROR),
    ("import ctypes\ndef f(x): ctypes.string_at(0)", FaultKind.RUNTIME_ERROR),
    ("def f(x): return bytearray(1 << 40)", FaultKind.MEMORY_LIMIT),
    ("import os\ndef f(x): os.fork()", FaultKind.FORBIDDEN_OPERATION),
    ("import os\nos.execv('/bin/sh', ['sh'])\ndef f(x): pass", FaultKind.FORBIDDEN_OPERATION),
    ("import socket\ndef f(x): socket.socket()", FaultKind.FORBIDDEN_OPERATION),
    (FORGED, FaultKind.INVALID_OUTPUT),
    ("def f(x): return object()", FaultKind.INVALID_OUTPUT),
    ("def f(x)", FaultKind.SYNTAX_ERROR),
    ("import tensorflow", FaultKind.IMPORT_ERROR),
    ("g = 1", FaultKind.MISSING_FUNCTION),
    (LEAVES_THINGS, None),
]
ENDLESS = "def f(x):\n    while True: pass"


def plan(chance: random.Random, submissions: int) -> Iterator[tuple[bytes, FaultKind | None, Policy]]:
    """One submission in four is hostile; a few of them wait for their time to run out."""
    for k in range(submissions):
        if k % 200 == 99:
            yield ENDLESS.encode(), FaultKind.TIMEOUT, HURRIED
        elif k % 4 == 3:
            source, kind = chance.choice(HOSTILE)
            yield source.encode(), kind, POLICY
        else:
            yield HONEST, None, POLICY


def outcome(sandbox: Sandbox, source: bytes, policy: Policy, x: int) -> object:
    """What the program answers or how it fails, graded again when the fault is ours, as a worker does."""
    for left in reversed(range(TRIES)):
        try:
            with sandbox.open(source, policy=policy) as session:
                return session.call("f", x).value
        except ProgramFault as fault:
            return fault.kind
        except SandboxFault:
            if not left:
                raise
    raise AssertionError


def serving() -> list[int]:
    """The templates that have come up, whose children are the students' programs."""
    roots = set(children(os.getpid())) - OTHERS
    return [template for root in roots for template in children(root)]


class Torment:
    """Kills and stops templates at moments that nobody expects, but never one submission twice: that one may fail."""

    def __init__(self, chance: random.Random, submissions: int) -> None:
        self._chance, self._graded, self._over = chance, 0, False
        self._pause = min(100, submissions // 6), min(400, submissions // 4)
        self.done: Counter[str] = Counter()

    @property
    def enough(self) -> bool:
        return self.done["SIGKILL"] >= 2 and self.done["SIGSTOP"] >= 1

    def graded(self) -> None:
        self._graded += 1

    def stop(self) -> None:
        self._over = True

    def run(self) -> None:
        while not self._over:
            after = self._graded + self._chance.randint(*self._pause)
            assert eventually(lambda after=after: self._graded >= after or self._over)
            time.sleep(self._chance.uniform(0.0, 0.01))
            assert eventually(lambda: self._over or self._strike())

    def _strike(self) -> bool:
        """Whether a template was there to be struck; returns once it has ended, so that the next blow hits others."""
        victims = serving()
        if not victims:
            return False
        victim = self._chance.choice(victims)
        number = (signal.SIGKILL, signal.SIGSTOP, signal.SIGKILL)[self.done.total() % 3]
        with contextlib.suppress(ProcessLookupError):
            os.kill(victim, number)
            self.done[number.name] += 1
        return eventually(lambda: self._over or not running(victim))


def belongings() -> dict[str, object]:
    """All that a sandbox could leave behind, of this process and on this machine."""
    groups = [
        path.name for hierarchy in usable_hierarchies()[0] for path in hierarchy.folder.glob(f"balise-{os.getpid()}-*")
    ]
    marked = [path for folder in ("/dev/shm", tempfile.gettempdir(), ".") for path in Path(folder).glob(f"*{MARK}*")]
    segments = [line.split() for line in Path("/proc/sysvipc/shm").read_text().splitlines()]
    return {
        "processes": templates(),
        "zombies": len(children(os.getpid())),
        "descriptors": len(os.listdir("/proc/self/fd")),
        "threads": threading.active_count(),
        "tasks": len(os.listdir("/proc/self/task")),
        "mounts": Path("/proc/self/mountinfo").read_text(),
        "control groups": groups,
        "files": marked,
        "memory files": Path("/proc/self/maps").read_text().count("memfd:"),
        "shared memory": [fields for fields in segments if str(UNPRIVILEGED) in fields[OWNERS]],
    }


@pytest.mark.long
@pytest.mark.parametrize("count", [FEWER, pytest.param(SUBMISSIONS, marks=pytest.mark.slow)])
def test_a_long_life_among_hostile_programs_leaves_nothing_behind(
    count: int, capsys: pytest.CaptureFixture[str]
) -> None:
    with Sandbox({}, POLICY) as sandbox:  # what is read once and kept is not a leak
        outcome(sandbox, HONEST, POLICY, 3)
    settle()
    before, torment = belongings(), Torment(random.Random(SEED + 1), count)
    submissions = list(plan(random.Random(SEED), count))
    started = time.monotonic()

    def submit(k: int) -> object:
        source, _, policy = submissions[k]
        got = outcome(sandbox, source, policy, k)
        torment.graded()
        return got

    with Sandbox({}, POLICY, max_forks=count // 4) as sandbox, ThreadPoolExecutor(THREADS + 1) as pool:
        tormenting = pool.submit(torment.run)
        try:
            came = list(pool.map(submit, range(count)))
            while not (torment.enough or tormenting.done()):  # a busy machine takes long to replace what was struck
                assert outcome(sandbox, HONEST, POLICY, 3) == 3.0
                torment.graded()
        finally:
            torment.stop()
        tormenting.result()
    with capsys.disabled():
        print(f"\n{count} submissions in {time.monotonic() - started:.1f} s, {dict(torment.done)}")
    for k, ((source, kind, _), got) in enumerate(zip(submissions, came, strict=True)):
        assert got == (float(sum(range(k))) if kind is None else kind), source.decode()
    assert torment.enough
    eventually(lambda: belongings() == before)
    assert belongings() == before
