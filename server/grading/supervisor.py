"""Starts the local workers, starts them again when they die, and takes their leases back at once."""

import asyncio
import logging
import os
import signal
import socket
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from server.base.concurrency import Gate, GateClosed
from server.base.processes import child_environment
from server.base.settings import Settings
from server.queue.lease_owner import LeaseOwner, process_owner
from server.queue.wakeups import WakeupDispatcher

log = logging.getLogger(__name__)

WORKER_COMMAND = (sys.executable, "-P", "-m", "server.grading")
STOP_SECONDS = 3.0
QUICK_DEATH = 2.0  # seconds: a worker that lives less long than this is started again after a pause
PAUSE = 1.0
LAST_WORDS = 0.5


class WorkerSocket:
    """Fills the port `server.queue.wakeups.Line`: few bytes now and then, on a socket that never waits."""

    def __init__(self, ours: socket.socket) -> None:
        self._ours = ours

    def write(self, data: bytes) -> None:
        """A worker that has died is started again and looks by itself; so does one that has read nothing for long."""
        with suppress(BlockingIOError, ConnectionError):
            self._ours.send(data)

    def close(self) -> None:
        self._ours.close()


@dataclass(frozen=True)
class WorkerProcess:
    """A worker process and what leads to it; `writer` keeps the socket that `wire` has a second name of."""

    process: asyncio.subprocess.Process
    owner: LeaseOwner
    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter
    wire: WorkerSocket


class WorkerSupervisor:
    """Keeps `settings.workers` processes alive, once the walls are known to stand.

    `on_death` is called in a thread with the dead worker's lease name.
    """

    def __init__(
        self,
        settings: Settings,
        dispatcher: WakeupDispatcher,
        on_death: Callable[[LeaseOwner], None],
        command: Sequence[str] = WORKER_COMMAND,
        walls: Gate | None = None,
    ) -> None:
        self._walls = walls or Gate(opened=True)
        self._settings, self._switchboard, self._on_death, self._command = settings, dispatcher, on_death, command
        self._running: dict[int, WorkerProcess] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._stopping = False

    async def __aenter__(self) -> "WorkerSupervisor":
        self._tasks = [asyncio.create_task(self._keep(slot)) for slot in range(self._settings.workers)]
        return self

    @property
    def target_count(self) -> int:
        return self._settings.workers

    @property
    def stopping(self) -> bool:
        return self._stopping

    def alive_count(self) -> int:
        """How many workers stand at this moment."""
        return sum(running.process.returncode is None for running in list(self._running.values()))

    def expect_shutdown(self) -> None:
        """The server has been told to stop: workers that end now, having been told too, are missed by nobody."""
        self._stopping = True

    async def __aexit__(self, *_exc: object) -> None:
        self._stopping = True
        if self._tasks:
            self._signal(signal.SIGTERM)
            _, late = await asyncio.wait(self._tasks, timeout=STOP_SECONDS)
            self._signal(signal.SIGKILL if late else signal.SIGTERM)
            await asyncio.gather(*self._tasks)

    def _signal(self, number: signal.Signals) -> None:
        for running in self._running.values():
            if running.process.returncode is None:
                with suppress(ProcessLookupError):
                    running.process.send_signal(number)

    async def _keep(self, slot: int) -> None:
        try:
            await self._walls.wait_open()
        except GateClosed:
            return
        while not self._stopping:
            born = asyncio.get_running_loop().time()
            running = self._running[slot] = await self._start()
            code = await self._until_death(running)
            await asyncio.to_thread(self._on_death, running.owner)
            await self._pause(code, born)

    async def _until_death(self, running: WorkerProcess) -> int:
        listening = asyncio.create_task(self._listen(running))
        code = await running.process.wait()
        await asyncio.wait([listening], timeout=LAST_WORDS)  # what it said before dying is still in the socket
        listening.cancel()
        self._switchboard.remove_worker(running.wire)  # from here on, nobody writes to it
        running.wire.close()
        running.writer.close()
        return code

    async def _pause(self, code: int, born: float) -> None:
        if self._stopping:
            return
        log.error("a worker has ended with status %d; starting another", code)
        if asyncio.get_running_loop().time() - born < QUICK_DEATH:
            await asyncio.sleep(PAUSE)

    async def _start(self) -> WorkerProcess:
        ours, theirs = socket.socketpair()
        with theirs:
            arguments = [*self._command, str(theirs.fileno()), str(os.getpid())]
            process = await asyncio.create_subprocess_exec(
                *arguments,
                pass_fds=[theirs.fileno()],
                env=child_environment(self._settings),
                stdin=asyncio.subprocess.DEVNULL,
            )
        owner, wire = process_owner(process.pid), WorkerSocket(ours.dup())
        reader, writer = await asyncio.open_connection(sock=ours)  # which has neither of its names wait
        return WorkerProcess(process, owner, reader, writer, wire)

    async def _listen(self, running: WorkerProcess) -> None:
        with suppress(ConnectionError):
            while line := await running.reader.readline():
                self._switchboard.handle_message(running.wire, line.decode().rstrip("\n"))
