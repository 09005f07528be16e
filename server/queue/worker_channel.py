"""The worker's end of the wake-up: a socket shared with the web process (see `server.queue.wakeups`)."""

import select
import socket
import threading

from sqlalchemy.orm import Session

from server.database import run_after_commit
from server.queue.interfaces import JobNotification
from server.queue.wakeups import AWAKE, CHANGED, IDLE, QUEUED, RENEWED


class WorkerChannel:
    """Work source and signals of a worker that the web process has started."""

    buffers_wakeups = True  # its switchboard does

    def __init__(self, wire: socket.socket) -> None:
        self._wire = wire
        self._sending = threading.Lock()

    def wait(self, seconds: float) -> bool:
        """Sleeps until woken, or `seconds`; False once the web process is gone."""
        self._say(IDLE)
        ready, _, _ = select.select([self._wire], [], [], seconds)
        if ready:
            return self._receive()
        self._say(AWAKE)
        return True

    def _receive(self) -> bool:
        try:
            return bool(self._wire.recv(4096))
        except ConnectionError:
            return False

    def _say(self, message: str) -> None:
        try:
            with self._sending:
                self._wire.sendall(f"{message}\n".encode())
        except ConnectionError:
            return  # the web process is gone: `wait` finds it out, the result is safe in the database

    def job_queued(self, db: Session, _call: JobNotification) -> None:
        run_after_commit(db, lambda: self._say(QUEUED))

    def job_changed(self, db: Session, news: str) -> None:
        run_after_commit(db, lambda: self._say(f"{CHANGED} {news}"))

    def template_renewed(self, reason: str) -> None:
        """A template of the sandbox was replaced."""
        self._say(f"{RENEWED} {reason}")
