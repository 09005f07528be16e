"""A process that holds the course's functions for one program, and the program's calls of them.

It is a fork behind the same walls, under the same limits, that runs no line of the program. Calls and replies are
passed on unread: the program's process and this one encode and decode them.
"""

from __future__ import annotations

from collections.abc import Callable

from server.sandbox import diagnosis
from server.sandbox.batch import random_token
from server.sandbox.child import codec, course_calls, frames
from server.sandbox.child.codec import Value
from server.sandbox.connection import EXIT_SECONDS, ChildConnection, encode_configuration
from server.sandbox.faults import FaultKind, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child
from server.sandbox.values import Kit, encode_library
from server.sandbox.wire import DeadlineExceeded, ForgedAnswer, WireClosed

#: Calls of the course's functions that one execution of a program may make.
MAX_CALLS = 100_000
TOO_MANY_CALLS = f"mes_fonctions : plus de {MAX_CALLS} appels"
_REPLIES = frozenset({frames.VALUE, frames.FAULT})


def _reply(*items: Value) -> bytes:
    return codec.encode(items, frames.ASK_LIMITS)


_EXPIRED = _reply(course_calls.EXPIRED)
_NO_MEMORY = course_calls.encode_raised(MemoryError())
_TOO_MANY = course_calls.encode_raised(RuntimeError(TOO_MANY_CALLS))
#: Replies to calls that used up the process's own limits.
_REPLIES_AT_LIMITS = {FaultKind.TIMEOUT: _EXPIRED, FaultKind.MEMORY_LIMIT: _NO_MEMORY}


class CourseProcess(ChildConnection):
    """Holds the course's functions."""

    def __init__(self, child: Child, policy: Policy) -> None:
        super().__init__(child, policy)
        self._last_reply: bytes | None = None

    def hold(self, kit: Kit) -> None:
        """Send it the course's files. Raises TemplateFault when the child was not sound."""
        self._join_seat()
        self._expect(0, frames.READY)
        question: dict[str, Value] = {"library": encode_library(kit.sealed_files), "offered": kit.course_functions}
        configure, hold = random_token(), random_token()
        self._send_setup(
            frames.pack_frame(configure, frames.CONFIGURE, encode_configuration(kit))
            + frames.pack_frame(hold, frames.HOLD, codec.encode(question, frames.QUESTION_LIMITS))
        )
        self._expect(configure, frames.CONFIGURED)
        self._expect(hold, frames.CONFIGURED)

    def answer(self, question: bytes) -> bytes:
        """Return the reply to a call. Raises SandboxFault when the process failed.

        Calls have as much time of the processor, and as much time in all, as the program itself.
        """
        if self._last_reply is not None:
            return self._last_reply
        began, token = self._clock(), random_token()
        try:
            outcome, reply = self._child.wire.exchange(
                token, frames.ASK, question, _REPLIES, frames.ASK_LIMITS.size, began + self._seconds_left
            )
            return reply if outcome == frames.VALUE else self._reply_to_fault(self._read_fault(reply))
        except DeadlineExceeded:
            return self._reply_to_fault(diagnosis.wall_timeout_fault(self._policy))
        except (WireClosed, ForgedAnswer, codec.MalformedValue, TemplateFault) as error:
            return self._reply_to_fault(self._find_fault(error))
        finally:
            self._waited += self._clock() - began

    def _read_fault(self, fault: bytes) -> ProgramFault | None:
        return diagnosis.parse_fault(codec.decode(fault, frames.FAULT_LIMITS), self._policy)

    def _find_fault(self, error: Exception) -> ProgramFault:
        """Return how a process that does not answer ended. Raises SandboxFault for one that has failed, Abandoned."""
        self._raise_if_abandoned()
        try:
            return diagnosis.exit_fault(self._child.wait_exit(EXIT_SECONDS), self._policy)
        except (TemplateFault, TimeoutError) as failure:
            raise SandboxFault(f"the process of the course's functions failed: {error!r}, {failure!r}") from failure

    def _reply_to_fault(self, fault: ProgramFault | None) -> bytes:
        reply = _REPLIES_AT_LIMITS.get(fault.kind) if fault else None
        if reply is None:
            raise SandboxFault(f"the course's functions failed: {fault}")
        self._last_reply = reply
        return reply

    def close(self) -> None:
        """End the process."""
        self._leave_seat()
        self._child.close()


class CourseCalls:
    """The calls of one program; the process starts at the first one."""

    def __init__(self, start: Callable[[], CourseProcess]) -> None:
        self._start = start
        self._process: CourseProcess | None = None
        self._calls = 0

    def answer(self, question: bytes) -> bytes:
        """Return the reply to a call. Raises SandboxFault when we failed."""
        if self._process is None:
            self._process = self._start()
        self._calls += 1
        return _TOO_MANY if self._calls > MAX_CALLS else self._process.answer(question)

    def close(self) -> None:
        if self._process is not None:
            self._process.close()
