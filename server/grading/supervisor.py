"""Starts the local workers, restarts them when they die, and recovers their leases at once."""

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
QUICK_DEATH_SECONDS = 2.0  # a worker that lives less long is restarted after a pause
RESTART_PAUSE = 1.0
DRAIN_SECONDS = 0.5


class WorkerWakeupSocket:
    """Implements `server.queue.wakeups.WorkerConnection`: a few bytes now and then, on a non-blocking socket."""

    def __init__(self, ours: socket.socket) -> None:
        self._socket = ours

    def write(self, data: bytes) -> None:
        """Send, or drop: a dead worker is restarted and polls by itself; so does one that has not read for long."""
        with suppress(BlockingIOError, ConnectionError):
            self._socket.send(data)

    def close(self) -> None:
        self._socket.close()


@dataclass(frozen=True)
class WorkerProcess:
    """A worker process and its connection; `writer` owns the socket that `wire` duplicates."""

    process: asyncio.subprocess.Process
    owner: LeaseOwner
    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter
    wire: WorkerWakeupSocket


class WorkerSupervisor:
    """Keeps `settings.workers` processes alive, once the sandbox's walls are proven.

    `on_death` is called in a thread with the dead worker's lease owner.
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
        self._processes: dict[int, WorkerProcess] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._stopping = False

    async def __aenter__(self) -> "WorkerSupervisor":
        self._tasks = [
            asyncio.create_task(self._restart_worker_until_stopped(slot)) for slot in range(self._settings.workers)
        ]
        return self

    @property
    def target_worker_count(self) -> int:
        return self._settings.workers

    @property
    def is_stopping(self) -> bool:
        return self._stopping

    def alive_worker_count(self) -> int:
        """Count the workers that run at this moment."""
        return sum(worker.process.returncode is None for worker in list(self._processes.values()))

    def stop_restarting_workers(self) -> None:
        """The server is stopping: workers that exit from now on are not restarted."""
        self._stopping = True

    async def __aexit__(self, *_exc: object) -> None:
        self._stopping = True
        if self._tasks:
            self._send_signal_to_workers(signal.SIGTERM)
            _, late = await asyncio.wait(self._tasks, timeout=STOP_SECONDS)
            self._send_signal_to_workers(signal.SIGKILL if late else signal.SIGTERM)
            await asyncio.gather(*self._tasks)

    def _send_signal_to_workers(self, number: signal.Signals) -> None:
        for worker in self._processes.values():
            if worker.process.returncode is None:
                with suppress(ProcessLookupError):
                    worker.process.send_signal(number)

    async def _restart_worker_until_stopped(self, slot: int) -> None:
        try:
            await self._walls.wait_open()
        except GateClosed:
            return
        while not self._stopping:
            started = asyncio.get_running_loop().time()
            worker = self._processes[slot] = await self._start_worker()
            code = await self._wait_for_worker_exit(worker)
            await asyncio.to_thread(self._on_death, worker.owner)
            await self._pause_before_restart(code, started)

    async def _wait_for_worker_exit(self, worker: WorkerProcess) -> int:
        listening = asyncio.create_task(self._listen_to_worker(worker))
        code = await worker.process.wait()
        await asyncio.wait([listening], timeout=DRAIN_SECONDS)  # its last messages are still in the socket
        listening.cancel()
        self._switchboard.remove_worker(worker.wire)  # nobody writes to it from here on
        worker.wire.close()
        worker.writer.close()
        return code

    async def _pause_before_restart(self, code: int, started: float) -> None:
        if self._stopping:
            return
        log.error("a worker has ended with status %d; starting another", code)
        if asyncio.get_running_loop().time() - started < QUICK_DEATH_SECONDS:
            await asyncio.sleep(RESTART_PAUSE)

    async def _start_worker(self) -> WorkerProcess:
        ours, theirs = socket.socketpair()
        with theirs:
            arguments = [*self._command, str(theirs.fileno()), str(os.getpid())]
            process = await asyncio.create_subprocess_exec(
                *arguments,
                pass_fds=[theirs.fileno()],
                env=child_environment(self._settings),
                stdin=asyncio.subprocess.DEVNULL,
            )
        owner, wire = process_owner(process.pid), WorkerWakeupSocket(ours.dup())
        reader, writer = await asyncio.open_connection(sock=ours)  # makes both duplicates non-blocking
        return WorkerProcess(process, owner, reader, writer, wire)

    async def _listen_to_worker(self, worker: WorkerProcess) -> None:
        with suppress(ConnectionError):
            while line := await worker.reader.readline():
                self._switchboard.handle_message(worker.wire, line.decode().rstrip("\n"))
