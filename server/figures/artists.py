"""Forks of the process that draws, each of which draws one picture after the other: a slow one holds up no other."""

from __future__ import annotations

import gc
import os
import signal
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import NoReturn

from server.base.processes import die_with_parent

#: Forks that wait for something to draw.
_MAX_IDLE = 1

#: From a question to the picture, as bytes; None where it cannot be drawn.
Draw = Callable[[bytes], bytes | None]


class DrawingFork:
    """A fork. It has all that is loaded by then, and keeps what it loads."""

    def __init__(self, draw: Draw, cpu_seconds: float) -> None:
        parent = os.getpid()
        self._channel, inner = Pipe()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # the threads beside it only wait for other forks
            self._pid = os.fork()
        if self._pid == 0:
            _serve_drawings_until_closed(inner, parent, draw, cpu_seconds)
        inner.close()
        self._ended = False

    def request_picture(self, request_json: bytes) -> bytes | None:
        """Return the picture; None where there is none. Raises EOFError or OSError where the fork has ended."""
        self._channel.send_bytes(request_json)
        picture: bytes | None = self._channel.recv()
        return picture

    def has_ended(self) -> bool:
        """Whether it has ended by itself, or was killed."""
        if not self._ended:
            self._ended = os.waitpid(self._pid, os.WNOHANG) != (0, 0)
        return self._ended

    def terminate(self) -> None:
        self._channel.close()
        if self._ended:
            return
        with suppress(ProcessLookupError):
            os.kill(self._pid, signal.SIGKILL)
        os.waitpid(self._pid, 0)


class DrawingForkPool:
    """Artists, as many as pictures are drawn at once; one that waits is used again."""

    def __init__(self, draw: Draw, cpu_seconds: float) -> None:
        self._draw, self._cpu_seconds = draw, cpu_seconds
        self._idle: list[DrawingFork] = []
        self._lock = threading.Lock()

    def take_idle_or_fork(self) -> DrawingFork:
        """Return an artist with nothing to draw. Called by one thread only, since it may fork."""
        with self._lock:
            idle = self._idle.pop() if self._idle else None
        if idle is not None:
            if not idle.has_ended():
                return idle
            idle.terminate()
        return DrawingFork(self._draw, self._cpu_seconds)

    def draw_with_fork(self, drawing_fork: DrawingFork, request_json: bytes) -> bytes | None:
        """Have a fork of `take_idle_or_fork` draw a picture; None where it cannot, or has ended by too much work."""
        try:
            picture = drawing_fork.request_picture(request_json)
        except (EOFError, OSError):
            drawing_fork.terminate()
            return None
        self._return_fork(drawing_fork)
        return picture

    def _return_fork(self, drawing_fork: DrawingFork) -> None:
        with self._lock:
            if len(self._idle) < _MAX_IDLE:
                self._idle.append(drawing_fork)
                return
        drawing_fork.terminate()


def _serve_drawings_until_closed(channel: Connection, parent: int, draw: Draw, cpu_seconds: float) -> NoReturn:
    try:
        die_with_parent(parent)
        gc.freeze()
        while True:
            question = channel.recv_bytes()
            signal.setitimer(signal.ITIMER_PROF, cpu_seconds)  # its signal ends the process, in the midst of C code too
            picture = draw(question)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
            channel.send(picture)
    finally:  # nothing of the parent's may run here
        os._exit(0)
