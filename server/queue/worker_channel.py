"""A worker's end of the wake-up channel: a socket shared with the web process (see `server.queue.wakeups`)."""

import select
import socket
import threading

from sqlalchemy.orm import Session

from server.database import run_after_commit
from server.queue.interfaces import JobNotification
from server.queue.wakeups import AWAKE, CHANGED, IDLE, QUEUED, RENEWED


class WorkerChannel:
    """Work source and notifier of a worker that the web process has started."""

    buffers_wakeups = True  # the dispatcher does

    def __init__(self, web_process: socket.socket) -> None:
        self._socket = web_process
        self._send_lock = threading.Lock()

    def wait(self, seconds: float) -> bool:
        """Sleep until woken, or for `seconds`; False once the web process is gone."""
        self._send(IDLE)
        ready, _, _ = select.select([self._socket], [], [], seconds)
        if ready:
            return self._receive()
        self._send(AWAKE)
        return True

    def _receive(self) -> bool:
        try:
            return bool(self._socket.recv(4096))
        except ConnectionError:
            return False

    def _send(self, message: str) -> None:
        try:
            with self._send_lock:
                self._socket.sendall(f"{message}\n".encode())
        except ConnectionError:
            return  # the web process is gone: `wait` notices; results are in the database

    def job_queued(self, db: Session, _notification: JobNotification) -> None:
        run_after_commit(db, lambda: self._send(QUEUED))

    def job_changed(self, db: Session, notification: str) -> None:
        run_after_commit(db, lambda: self._send(f"{CHANGED} {notification}"))

    def template_renewed(self, reason: str) -> None:
        """Report that a template of the sandbox was replaced."""
        self._send(f"{RENEWED} {reason}")
