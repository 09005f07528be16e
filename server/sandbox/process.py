"""The trusted side of a template: starts it, orders forks and kills, receives the exit of each child."""

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
from typing import Any, TypeVar

from server.sandbox import liveness
from server.sandbox.cgroups import ControlGroup, ControlGroupPool
from server.sandbox.child import codec, orders, outer
from server.sandbox.child.template import CONTROL_LIMITS
from server.sandbox.course_pipes import CourseChannel, make_course_channel
from server.sandbox.faults import NamespacesRefused, SandboxFault, TemplateFault
from server.sandbox.launch import TemplateConfig, launch_template_process
from server.sandbox.output import CapturedOutput
from server.sandbox.policy import Policy
from server.sandbox.wire import Wire

_log = logging.getLogger(__name__)
Done = TypeVar("Done")
START_SECONDS = 60.0
_END_SECONDS = 3.0
#: A ``struct timeval``: a template that takes no order for so long is as good as dead.
_SEND_TIMEOUT = struct.pack("@ll", 5, 0)
_MAX_MESSAGE_BYTES = 1 << 17
#: A ``struct ucred``: process, user, group.
_CREDENTIALS = struct.Struct("3i")


@dataclass(frozen=True)
class ChildExit:
    """Exit of a child as `os.wait4` reports it, and whether its control group reports an out-of-memory kill."""

    status: int
    cpu_seconds: float
    max_rss_bytes: int
    out_of_memory: bool = False


class Child:
    """A fork behind its walls: its wire, its output, the far ends of its pipes to the course, and its exit."""

    def __init__(
        self, template: TemplateProcess, number: int, wire: Wire, output: CapturedOutput, channel: CourseChannel
    ) -> None:
        self._template, self._number = template, number
        self.wire, self.output, self.channel = wire, output, channel
        self._exit: Future[ChildExit] = template.exit_future(number)
        self._killed = False
        #: Callback after `close`.
        self.on_close: Callable[[], object] = lambda: None

    def kill(self) -> None:
        if not (self._killed or self.has_exited()):
            self._killed = True
            self._template.order(self._number, orders.pack_kill_order)

    def stop(self) -> None:
        """Stop it until `go_on`."""
        self._template.order(self._number, orders.pack_stop_order)

    def go_on(self, alarm_at: float) -> None:
        """Let it go on; its time of the wall runs out at `alarm_at` of `time.monotonic`, if a call runs."""
        self.output.set_alarm(alarm_at)
        self._template.order(self._number, orders.pack_continue_order)

    def wait_exit(self, timeout: float) -> ChildExit:
        """Wait for the exit. Raises TemplateFault when the template died first, TimeoutError while the child lives."""
        return self._exit.result(timeout)

    def has_exited(self) -> bool:
        return self._exit.done()

    def close(self) -> None:
        self.kill()
        self.wire.close()
        self.output.close()
        self.channel.close()
        self.on_close()


class TemplateProcess:
    """One template. `start` must be called from a thread that outlives it: its death kills the template."""

    def __init__(
        self, config: TemplateConfig, groups: ControlGroupPool, on_idle: Callable[[TemplateProcess], None]
    ) -> None:
        self._config, self._groups, self._on_idle = config, groups, on_idle
        self._lock = threading.Lock()
        self._groups_in_use: dict[int, ControlGroup] = {}
        self._sending = threading.Lock()
        self._exits: dict[int, Future[ChildExit]] = {}
        self._dead = False
        self._last_stderr = ""
        self.namespaces = config.namespaces
        self.forks = 0
        #: Bytes of private memory that it gained since its start.
        self.memory_growth = 0
        self.greeting: dict[str, Any] = {}

    def start(self, spawner: ThreadPoolExecutor) -> TemplateProcess:
        """Start the process. Raises TemplateFault, with its standard error, when it does not come up."""
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._log = os.memfd_create("log", os.MFD_CLOEXEC)
        try:
            with theirs:
                self._control.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 1)
                self._process = spawner.submit(
                    launch_template_process, self._config, theirs.fileno(), self._log
                ).result()
            self._await_greeting()
        except BaseException:
            self._control.close()
            os.close(self._log)
            raise
        self._control.setsockopt(socket.SOL_SOCKET, socket.SO_SNDTIMEO, _SEND_TIMEOUT)
        self._listener = threading.Thread(target=self._listen, name="sandbox-template", daemon=True)
        self._listener.start()
        return self

    def _await_greeting(self) -> None:
        try:
            hello, pid = self._receive_greeting()
            self._handle = liveness.ProcessHandle(pid)
        except Exception as error:
            code = self._wait_or_kill(1.0 if isinstance(error, EOFError) else 0.0)
            kind = NamespacesRefused if code == outer.REFUSED else TemplateFault
            raise kind(f"the template did not start ({code}, {error!r}): {self.stderr_tail()}") from error
        # Credentials asked for would give this end a name that all can see when it sends.
        self._control.setsockopt(socket.SOL_SOCKET, socket.SO_PASSCRED, 0)
        self._control.settimeout(None)
        self.greeting = hello

    def _receive_greeting(self) -> tuple[dict[str, Any], int]:
        """Return the template's greeting, and its pid in this namespace, which the kernel adds as credentials."""
        deadline, watch = time.monotonic() + START_SECONDS, liveness.HangDetector()
        self._control.settimeout(liveness.POLL_SECONDS)
        while True:
            try:
                data, ancillary, _, _ = self._control.recvmsg(_MAX_MESSAGE_BYTES, socket.CMSG_SPACE(_CREDENTIALS.size))
                break
            except TimeoutError:
                if watch.hangs_at_start(self._process.pid) or time.monotonic() > deadline:
                    raise
        if not data:
            raise EOFError
        hello: Any = codec.decode(data, CONTROL_LIMITS)
        match hello:
            case {"do": "hello", "memory": int()}:
                pid, _, _ = _CREDENTIALS.unpack(ancillary[0][2])
                return hello, pid
        raise ValueError(f"no greeting: {hello!r:.500}")

    def _wait_or_kill(self, seconds: float) -> int:
        """Wait for the first process, kill it after `seconds`, and return its exit code."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        self._process.kill()
        return self._process.wait()

    def stderr_tail(self) -> str:
        """Return the end of the template's standard error."""
        with self._lock:
            return self._last_stderr if self._dead else self._read_stderr_tail()

    def _read_stderr_tail(self) -> str:
        size = os.fstat(self._log).st_size
        return os.pread(self._log, 8192, max(0, size - 8192)).decode("utf-8", "replace")

    def fork(self, policy: Policy, caller: CourseChannel | None = None) -> Child:
        """Order a child, without waiting for it to start. Raises TemplateFault when the template is gone.

        It is made to call functions of the course, or to answer the calls that come on the channel of `caller`.
        """
        output = CapturedOutput(policy.stdout_bytes)
        ours, theirs = socket.socketpair()
        near, far = (caller, CourseChannel()) if caller else make_course_channel()
        with self._lock:
            self.forks += 1
            number = self.forks
            self._exits[number] = Future()
        child = Child(self, number, Wire(ours), output, far)
        group = self._groups.acquire(policy)
        if group:
            self._groups_in_use[number] = group
        try:
            with theirs:
                descriptors = [
                    theirs.fileno(),
                    output.fileno(),
                    output.traceback_descriptor,
                    *near.descriptors,
                    *(group.descriptors if group else ()),
                ]
                self._send_order(orders.pack_fork_order(number, _child_limits(policy)), descriptors)
        except TemplateFault:
            child.close()
            self._unregister_child(number)
            raise
        finally:
            if near is not caller:
                near.close()
        return child

    def _unregister_child(self, number: int) -> None:
        """Undo the registration of a child that could not be ordered."""
        with self._lock:
            self._exits.pop(number, None)
        if group := self._groups_in_use.pop(number, None):
            self._groups.release(group)

    def exit_future(self, number: int) -> Future[ChildExit]:
        return self._exits[number]

    def order(self, number: int, pack: Callable[[int], bytes]) -> None:
        """Order a child to be killed, stopped or continued, unless it has ended."""
        with self._lock:
            known = number in self._exits and not self._dead
        if known:
            with contextlib.suppress(TemplateFault):  # a dead template has taken its children along
                self._send_order(pack(number), [])

    def _send_order(self, data: bytes, descriptors: list[int]) -> None:
        with self._sending:  # not the other lock: a template that takes no order must not keep anyone from learning it
            if self._dead:
                raise TemplateFault("the template is gone")
            try:
                socket.send_fds(self._control, [data], descriptors)
            except OSError as error:
                raise TemplateFault("the template is gone") from error

    def is_idle(self) -> bool:
        with self._lock:
            return not self._exits

    def is_alive(self) -> bool:
        return not self._dead

    def _listen(self) -> None:
        try:
            watch = liveness.HangDetector()
            while data := self._receive_report(watch):
                self._record_exit(orders.unpack_report(data))
                self._on_idle(self)
        except Exception:
            _log.exception("a template reports nonsense, and is ended")
        finally:
            self._kill_and_fail_pending()

    def _receive_report(self, watch: liveness.HangDetector) -> bytes:
        """Wait for the next report; empty when the template is gone or hangs."""
        coming = select.poll()
        coming.register(self._control, select.POLLIN)
        while not coming.poll(1000.0 * liveness.POLL_SECONDS):
            if watch.hangs_while_serving(self._handle.pid, self._control.fileno()):
                _log.error("a template hangs (%s), and is ended", liveness.process_state(self._handle.pid))
                return b""
        watch.reset()
        try:
            return self._control.recv(_MAX_MESSAGE_BYTES)
        except OSError:
            return b""

    def _record_exit(self, report: orders.ExitReport) -> None:
        number, status = report.child_number, report.status
        ending = ChildExit(status, report.cpu_seconds, report.max_rss_bytes, self._release_group(number, status))
        self.memory_growth = report.template_memory - self.greeting["memory"]
        with self._lock:
            known = self._exits.pop(number)
        known.set_result(ending)

    def _release_group(self, number: int, status: int) -> bool:
        """Release the control group of an ended child; return whether the kernel killed it for lack of memory."""
        group = self._groups_in_use.pop(number, None)
        if group is None:
            return False
        exhausted = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL and group.was_oom_killed()
        self._groups.release(group)
        return exhausted

    def _kill_and_fail_pending(self) -> None:
        """Kill the template, then its parent, and fail all pending exits."""
        if not self._handle.kill_and_wait(_END_SECONDS):
            _log.error("the template %d cannot be killed", self._handle.pid)
        self._handle.close()
        self._process.send_signal(signal.SIGCONT)
        self._wait_or_kill(_END_SECONDS)
        with self._sending, self._lock:
            self._dead = True
            left, self._exits = self._exits, {}
            self._last_stderr = self._read_stderr_tail()
            self._control.close()
            os.close(self._log)
        while self._groups_in_use:
            self._groups.retire(self._groups_in_use.popitem()[1])
        for ending in left.values():
            ending.set_exception(TemplateFault(f"the template died: {self._last_stderr}"))
        self._on_idle(self)

    def close(self) -> None:
        """End the template and all its children; return when they are gone."""
        with self._lock:
            if not self._dead:
                with contextlib.suppress(OSError):
                    self._control.shutdown(socket.SHUT_RDWR)
        if threading.current_thread() is not self._listener:
            self._listener.join()


def try_twice(action: Callable[[], Done]) -> Done:
    """Do it again if a template failed, which is replaced. Raises SandboxFault when the next one fails too."""
    try:
        return action()
    except TemplateFault as first:
        _log.warning("a template failed and is replaced: %s", first)
    try:
        return action()
    except TemplateFault as error:
        raise SandboxFault(str(error)) from error


def _child_limits(policy: Policy) -> orders.ChildLimits:
    answer = policy.answer_limits
    return orders.ChildLimits(
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
