"""The preview's parent: it listens, forks a process for each version of the files, and never imports any of them.

What takes long to import is imported here, once. A fork then has a fresh interpreter for all that the author writes, in
the time that their own code takes; it answers on the same socket, and the one before it ends once it does.
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from graders.courses import ROOMS

#: Seconds of processor that the import of a course may take, and seconds in all: a busy machine ends no import, and one
#: that loops for ever, or waits for ever, leaves the version before it in place.
IMPORT_SECONDS, START_TIMEOUT, LOOK_SECONDS = 30.0, 120.0, 0.5
#: What makes a process's number the one of its clock (Linux, `clock_getcpuclockid`).
PROCESS_CLOCK = 2
READY = b"ready"
Report = Callable[[str], None]


@dataclass(frozen=True)
class PreviewSession:
    """What the processes of one preview share: the course's folder, what is kept meanwhile, which version this is."""

    course_folder: Path
    data_dir: Path
    generation: int = 0

    @property
    def faults_file(self) -> Path:
        """Where what is wrong with this version is written, once it is known."""
        return self.data_dir / f"faults-{self.generation}.json"


@dataclass
class VersionProcesses:
    """The processes of one version."""

    server: int
    checker: int


@dataclass
class PreviewSupervisor:
    """`serve` and `look` are what the two processes of a version do; both are forked, and end with this one."""

    course_folder: Path
    listener: socket.socket
    serve: Callable[[PreviewSession, socket.socket, Callable[[], None]], None]
    check: Callable[[PreviewSession], None]
    report: Report
    data_dir: Path = field(init=False)
    generation: int = 0

    def run(self) -> None:
        """Serve until interrupted."""
        with (
            tempfile.TemporaryDirectory(prefix="balise-preview-") as kept,
            _watch_changes(self.course_folder) as changes,
        ):
            self.data_dir = Path(kept)
            running = self._start_version()
            try:
                while True:
                    changed = next(changes)
                    self.report(
                        f"{_describe_changes(changed, self.course_folder)} : relu en {self._restart_version(running)}."
                    )
            except (KeyboardInterrupt, StopIteration):
                pass
            finally:
                _stop_version(running)

    def _restart_version(self, running: VersionProcesses) -> str:
        begun = time.monotonic()
        _kill_and_reap(running.checker)
        fresh = self._start_version(instead_of=running)
        running.server, running.checker = fresh.server, fresh.checker
        return f"{time.monotonic() - begun:.1f} s".replace(".", ",")

    def _start_version(self, instead_of: VersionProcesses | None = None) -> VersionProcesses:
        """The processes of the next version; where its server does not come up, the one before it stays."""
        self.generation += 1
        session = PreviewSession(self.course_folder, self.data_dir, self.generation)
        told, tells = os.pipe()
        server = _fork_to_run(lambda: self.serve(session, self.listener, lambda: _signal_ready(tells)), close=told)
        os.close(tells)
        up = _wait_until_ready(server, told)
        os.close(told)
        if up and instead_of is not None:
            _kill_and_reap(instead_of.server, signal.SIGTERM)
        elif not up:
            _kill_and_reap(server)
            self.report("Cette version ne démarre pas : l’import du cours ne finit pas, ou arrête Python.")
            server = instead_of.server if instead_of is not None else server
        return VersionProcesses(server, _fork_to_run(lambda: self.check(session)))


def _fork_to_run(work: Callable[[], None], close: int | None = None) -> int:
    """A process that does this and ends, whatever comes of it."""
    parent = os.getpid()
    child = os.fork()
    if child:
        return child
    status = 1
    try:
        from server.base.processes import die_with_parent

        die_with_parent(parent)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        if close is not None:
            os.close(close)
        work()
        status = 0
    except BaseException:  # nothing of the parent's may go on in here
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        os._exit(status)


def _signal_ready(pipe: int) -> None:
    os.write(pipe, READY)
    os.close(pipe)


def _wait_until_ready(process: int, pipe: int) -> bool:
    deadline = time.monotonic() + START_TIMEOUT
    while not select.select([pipe], [], [], LOOK_SECONDS)[0]:
        if time.monotonic() > deadline or time.clock_gettime((~process << 3) | PROCESS_CLOCK) > IMPORT_SECONDS:
            return False
    return os.read(pipe, len(READY)) == READY


def _kill_and_reap(process: int, number: signal.Signals = signal.SIGKILL) -> None:
    """Ends a process of ours, and waits for it where that takes no time."""
    try:
        os.kill(process, number)
        if number is signal.SIGKILL:
            os.waitpid(process, 0)
    except (ProcessLookupError, ChildProcessError):
        pass  # it has ended by itself


def _stop_version(running: VersionProcesses) -> None:
    _kill_and_reap(running.checker)
    _kill_and_reap(running.server, signal.SIGTERM)
    with suppress(ChildProcessError):
        os.waitpid(running.server, 0)


@contextmanager
def _watch_changes(place: Path) -> Iterator[Iterator[list[str]]]:
    """The changes of a course's files, as they come."""
    folders = [str(place / room) for room in ROOMS]
    command = [sys.executable, "-m", "server.authoring.preview.watching", str(os.getpid()), *folders]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield (json.loads(line) for line in process.stdout)
        finally:
            process.terminate()


def _describe_changes(changed: list[str], place: Path) -> str:
    first = os.path.relpath(changed[0], place)
    return first if len(changed) == 1 else f"{first} et {len(changed) - 1} de plus"
