"""The trusted side of a template: starts it, orders forks and kills, learns how each child ended."""

from __future__ import annotations

import contextlib
import logging
import os
import select
import signal
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from server.sandbox import vitals
from server.sandbox.cgroups import Seat, Seats
from server.sandbox.child import codec, orders, outer
from server.sandbox.child.template import CONTROL
from server.sandbox.faults import NamespacesRefused, TemplateFault
from server.sandbox.launch import Setting, launch
from server.sandbox.output import Output
from server.sandbox.policy import Policy
from server.sandbox.wire import Wire

_log = logging.getLogger(__name__)
START_SECONDS = 60.0
_END_SECONDS = 3.0
#: A ``struct timeval``: a template that takes no order for so long is as good as dead.
_SEND_TIMEOUT = struct.pack("@ll", 5, 0)
_MESSAGE = 1 << 17
#: A ``struct ucred``: process, user, group.
_CREDENTIALS = struct.Struct("3i")


@dataclass(frozen=True)
class Ending:
    """How a child ended, as `os.wait4` tells it, and whether its control group says that it lacked memory."""

    status: int
    cpu_seconds: float
    max_rss_bytes: int
    out_of_memory: bool = False


class Child:
    """A fork behind its walls: its wire, what it printed, and how it ended once it has."""

    def __init__(self, template: TemplateProcess, number: int, wire: Wire, output: Output) -> None:
        self._template, self._number = template, number
        self.wire, self.output = wire, output
        self._ending: Future[Ending] = template.ending(number)
        self._killed = False
        #: Called once it is closed.
        self.when_closed: Callable[[], object] = lambda: None

    def kill(self) -> None:
        if not (self._killed or self.ended()):
            self._killed = True
            self._template.kill(self._number)

    def ending(self, timeout: float) -> Ending:
        """Raises TemplateFault when the template is gone and nobody can tell, TimeoutError when it still lives."""
        return self._ending.result(timeout)

    def ended(self) -> bool:
        return self._ending.done()

    def close(self) -> None:
        self.kill()
        self.wire.close()
        self.output.close()
        self.when_closed()


class TemplateProcess:
    """One template. `start` must be called from a thread that outlives it: its death kills the template."""

    def __init__(self, setting: Setting, seats: Seats, when_idle: Callable[[TemplateProcess], None]) -> None:
        self._setting, self._seats, self._when_idle = setting, seats, when_idle
        self._lock = threading.Lock()
        self._taken: dict[int, Seat] = {}
        self._sending = threading.Lock()
        self._endings: dict[int, Future[Ending]] = {}
        self._dead = False
        self._words = ""
        self.namespaces = setting.namespaces
        self.forks = 0
        #: Bytes of its own memory that it has taken since it came up.
        self.growth = 0
        self.hello: dict[str, Any] = {}

    def start(self, spawner: ThreadPoolExecutor) -> TemplateProcess:
        """Raises TemplateFault, with what the process said, when it does not come up."""
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._log = os.memfd_create("log", os.MFD_CLOEXEC)
        try:
            with theirs:
                self._control.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
                self._process = spawner.submit(launch, self._setting, theirs.fileno(), self._log).result()
            self._greet()
        except BaseException:
            self._control.close()
            os.close(self._log)
            raise
        self._control.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _SEND_TIMEOUT)
        self._listener = threading.Thread(target=self._listen, name="sandbox-template", daemon=True)
        self._listener.start()
        return self

    def _greet(self) -> None:
        try:
            hello, pid = self._hello()
            self._life = vitals.Life(pid)
        except Exception as error:
            code = self._stopped(1.0 if isinstance(error, EOFError) else 0.0)
            kind = NamespacesRefused if code == outer.REFUSED else TemplateFault
            raise kind(f"the template did not start ({code}, {error!r}): {self.said()}") from error
        # Credentials asked for would give this end a name that all can see when it sends.
        self._control.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 0)
        self._control.settimeout(None)
        self.hello = hello

    def _hello(self) -> tuple[dict[str, Any], int]:
        """What the template says first, and its number among the processes of this side, which the kernel tells."""
        deadline, watch = time.monotonic() + START_SECONDS, vitals.Watch()
        self._control.settimeout(vitals.LOOK)
        while True:
            try:
                data, ancillary, _, _ = self._control.recvmsg(_MESSAGE, socket.CMSG_SPACE(_CREDENTIALS.size))
                break
            except TimeoutError:
                if watch.starting(self._process.pid) or time.monotonic() > deadline:
                    raise
        if not data:
            raise EOFError
        hello: Any = codec.decode(data, CONTROL)
        match hello:
            case {"do": "hello", "memory": int()}:
                pid, _, _ = _CREDENTIALS.unpack(ancillary[0][2])
                return hello, pid
        raise ValueError(f"no greeting: {hello!r:.500}")

    def _stopped(self, seconds: float) -> int:
        """The exit code of the first process, which is left so long to end by itself."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        self._process.kill()
        return self._process.wait()

    def said(self) -> str:
        """The end of what the template wrote on its standard error."""
        with self._lock:
            return self._words if self._dead else self._said()

    def _said(self) -> str:
        size = os.fstat(self._log).st_size
        return os.pread(self._log, 8192, max(0, size - 8192)).decode("utf-8", "replace")

    def fork(self, policy: Policy) -> Child:
        """Orders a child; it may still be on its way. Raises TemplateFault when the template is gone."""
        output = Output(policy.stdout_bytes)
        ours, theirs = socket.socketpair()
        with self._lock:
            self.forks += 1
            number = self.forks
            self._endings[number] = Future()
        child = Child(self, number, Wire(ours), output)
        seat = self._seats.take(policy)
        if seat:
            self._taken[number] = seat
        try:
            with theirs:
                descriptors = [theirs.fileno(), output.fileno(), output.words, *(seat.descriptors if seat else ())]
                self._order(orders.fork(number, _limits(policy)), descriptors)
        except TemplateFault:
            child.close()
            self._forget(number)
            raise
        return child

    def _forget(self, number: int) -> None:
        """A child that was not even ordered."""
        with self._lock:
            self._endings.pop(number, None)
        if seat := self._taken.pop(number, None):
            self._seats.give_back(seat)

    def ending(self, number: int) -> Future[Ending]:
        return self._endings[number]

    def kill(self, number: int) -> None:
        with self._lock:
            known = number in self._endings and not self._dead
        if known:
            with contextlib.suppress(TemplateFault):  # a dead template has taken its children along
                self._order(orders.kill(number), [])

    def _order(self, data: bytes, descriptors: list[int]) -> None:
        with self._sending:  # not the other lock: a template that takes no order must not keep anyone from learning it
            if self._dead:
                raise TemplateFault("the template is gone")
            try:
                socket.send_fds(self._control, [data], descriptors)
            except OSError as error:
                raise TemplateFault("the template is gone") from error

    def idle(self) -> bool:
        with self._lock:
            return not self._endings

    def alive(self) -> bool:
        return not self._dead

    def _listen(self) -> None:
        try:
            watch = vitals.Watch()
            while data := self._received(watch):
                self._note(orders.reported(data))
                self._when_idle(self)
        except Exception:
            _log.exception("a template reports nonsense, and is ended")
        finally:
            self._bury()

    def _received(self, watch: vitals.Watch) -> bytes:
        """The next report; empty when the template is gone or hangs."""
        coming = select.poll()
        coming.register(self._control, select.POLLIN)
        while not coming.poll(1000.0 * vitals.LOOK):
            if watch.serving(self._life.pid, self._control.fileno()):
                _log.error("a template hangs (%s), and is ended", vitals.state(self._life.pid))
                return b""
        watch.heard()
        try:
            return self._control.recv(_MESSAGE)
        except OSError:
            return b""

    def _note(self, report: orders.Report) -> None:
        number, status = report.number, report.status
        ending = Ending(status, report.cpu_seconds, report.max_rss_bytes, self._leave_seat(number, status))
        self.growth = report.memory - self.hello["memory"]
        with self._lock:
            known = self._endings.pop(number)
        known.set_result(ending)

    def _leave_seat(self, number: int, status: int) -> bool:
        """Gives back the seat of a child that has ended; returns whether the kernel ended it for lack of memory."""
        seat = self._taken.pop(number, None)
        if seat is None:
            return False
        exhausted = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL and seat.ran_out_of_memory()
        self._seats.give_back(seat)
        return exhausted

    def _bury(self) -> None:
        """The template goes first, so that its parent is there to take note of it."""
        if not self._life.end(_END_SECONDS):
            _log.error("the template %d cannot be killed", self._life.pid)
        self._life.close()
        self._process.send_signal(signal.SIGCONT)
        self._stopped(_END_SECONDS)
        with self._sending, self._lock:
            self._dead = True
            left, self._endings = self._endings, {}
            self._words = self._said()
            self._control.close()
            os.close(self._log)
        while self._taken:
            self._seats.drop(self._taken.popitem()[1])
        for ending in left.values():
            ending.set_exception(TemplateFault(f"the template died: {self._words}"))
        self._when_idle(self)

    def close(self) -> None:
        """Ends the template and all its children; returns when they are gone."""
        with self._lock:
            if not self._dead:
                with contextlib.suppress(OSError):
                    self._control.shutdown(socket.SHUT_RDWR)
        if threading.current_thread() is not self._listener:
            self._listener.join()


def _limits(policy: Policy) -> orders.Limits:
    answer = policy.answer
    return orders.Limits(
        cpu_seconds=policy.cpu_seconds,
        memory_bytes=policy.memory_bytes,
        files=policy.files,
        file_bytes=policy.file_bytes,
        folder_bytes=policy.folder_bytes,
        threads=policy.threads,
        stdout_bytes=policy.stdout_bytes,
        frame_bytes=answer.size,
        depth=answer.depth,
        items=answer.items,
    )
