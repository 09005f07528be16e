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

#: Seconds that the import of a course may take: one that loops for ever leaves the version before it in place.
PATIENCE = 30.0
READY = b"ready"
Say = Callable[[str], None]


@dataclass(frozen=True)
class Session:
    """What the processes of one preview share: the course's folder, what is kept meanwhile, which version this is."""

    place: Path
    kept: Path
    generation: int = 0

    @property
    def faults(self) -> Path:
        """Where what is wrong with this version is written, once it is known."""
        return self.kept / f"faults-{self.generation}.json"


@dataclass
class Running:
    """The processes of one version."""

    server: int
    looker: int


@dataclass
class Supervisor:
    """`serve` and `look` are what the two processes of a version do; both are forked, and end with this one."""

    place: Path
    listener: socket.socket
    serve: Callable[[Session, socket.socket, Callable[[], None]], None]
    look: Callable[[Session], None]
    say: Say
    kept: Path = field(init=False)
    generation: int = 0

    def run(self) -> None:
        """Until it is interrupted."""
        with tempfile.TemporaryDirectory(prefix="balise-preview-") as kept, _watching(self.place) as changes:
            self.kept = Path(kept)
            running = self._start()
            try:
                while True:
                    changed = next(changes)
                    self.say(f"{_told(changed, self.place)} : relu en {self._timed(running)}.")
            except (KeyboardInterrupt, StopIteration):
                pass
            finally:
                _end(running)

    def _timed(self, running: Running) -> str:
        begun = time.monotonic()
        _kill(running.looker)
        fresh = self._start(instead_of=running)
        running.server, running.looker = fresh.server, fresh.looker
        return f"{time.monotonic() - begun:.1f} s".replace(".", ",")

    def _start(self, instead_of: Running | None = None) -> Running:
        """The processes of the next version; where its server does not come up, the one before it stays."""
        self.generation += 1
        session = Session(self.place, self.kept, self.generation)
        told, tells = os.pipe()
        server = _forked(lambda: self.serve(session, self.listener, lambda: _tell(tells)), close=told)
        os.close(tells)
        up = _comes_up(told)
        os.close(told)
        if up and instead_of is not None:
            _kill(instead_of.server, signal.SIGTERM)
        elif not up:
            _kill(server)
            self.say("Cette version ne démarre pas : l’import du cours ne finit pas, ou arrête Python.")
            server = instead_of.server if instead_of is not None else server
        return Running(server, _forked(lambda: self.look(session)))


def _forked(work: Callable[[], None], close: int | None = None) -> int:
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


def _tell(pipe: int) -> None:
    os.write(pipe, READY)
    os.close(pipe)


def _comes_up(pipe: int) -> bool:
    readable, _, _ = select.select([pipe], [], [], PATIENCE)
    return bool(readable) and os.read(pipe, len(READY)) == READY


def _kill(process: int, number: signal.Signals = signal.SIGKILL) -> None:
    """Ends a process of ours, and waits for it where that takes no time."""
    try:
        os.kill(process, number)
        if number is signal.SIGKILL:
            os.waitpid(process, 0)
    except (ProcessLookupError, ChildProcessError):
        pass  # it has ended by itself


def _end(running: Running) -> None:
    _kill(running.looker)
    _kill(running.server, signal.SIGTERM)
    with suppress(ChildProcessError):
        os.waitpid(running.server, 0)


@contextmanager
def _watching(place: Path) -> Iterator[Iterator[list[str]]]:
    """The changes of a course's files, as they come."""
    folders = [str(place / room) for room in ROOMS]
    command = [sys.executable, "-m", "server.authoring.preview.watching", str(os.getpid()), *folders]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield (json.loads(line) for line in process.stdout)
        finally:
            process.terminate()


def _told(changed: list[str], place: Path) -> str:
    first = os.path.relpath(changed[0], place)
    return first if len(changed) == 1 else f"{first} et {len(changed) - 1} de plus"
