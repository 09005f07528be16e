"""Liveness of our own processes, from the kernel: their state, whether they hang, and their end."""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import signal
import struct
import termios
from pathlib import Path

#: Seconds between two checks of a silent process.
POLL_SECONDS = 0.25
#: Consecutive idle checks after which a process with work to do counts as hung.
_IDLE_POLLS_TO_HANG = 5
_STOPPED = frozenset("Tt")
_IDLE = frozenset("TtS")


def process_state(pid: int) -> str:
    """The letter of `proc(5)`; "" for a process that is gone, or that this user may not look at."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace").rpartition(")")[2].split()[0]
    except OSError:
        return ""


def child_process_ids(pid: int) -> list[int]:
    """The processes that this one has started; empty where the kernel does not tell."""
    try:
        return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()]
    except OSError:
        return []


def has_unread_data(end: int) -> bool:
    """Whether something sent on this Unix socket has not been received yet."""
    (waiting,) = struct.unpack("i", fcntl.ioctl(end, termios.TIOCOUTQ, b"\0" * 4))
    return bool(waiting > 0)


class HangDetector:
    """Tells a process that hangs from one that waits for a busy machine.

    A process with work before it is runnable, however long the machine makes it wait, or waits for a disk. One that was
    stopped, or sleeps on something else, at every look for a whole second, hangs.
    """

    def __init__(self) -> None:
        self._idle_polls = 0

    def reset(self) -> None:
        self._idle_polls = 0

    def hangs_at_start(self, pid: int) -> bool:
        """Whether a process that comes up, or what it has started, is stopped."""
        return self._count_idle_checks(
            any(process_state(process) in _STOPPED for process in (pid, *child_process_ids(pid)))
        )

    def hangs_while_serving(self, pid: int, control: int) -> bool:
        """Whether a process leaves what was sent to it on this socket unread for nothing."""
        return self._count_idle_checks(has_unread_data(control) and process_state(pid) in _IDLE)

    def _count_idle_checks(self, idle: bool) -> bool:
        self._idle_polls = self._idle_polls + 1 if idle else 0
        return self._idle_polls >= _IDLE_POLLS_TO_HANG


class ProcessHandle:
    """One process, which its number may outlive: from here on, it is this one and no other."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._handle = os.pidfd_open(pid)

    def kill_and_wait(self, seconds: float) -> bool:
        """Kills it; True once it is gone, False when it still is not after `seconds`."""
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._handle, signal.SIGKILL)
        gone = select.poll()
        gone.register(self._handle, select.POLLIN)
        return bool(gone.poll(1000.0 * seconds))

    def close(self) -> None:
        os.close(self._handle)
