"""A process that holds the course's functions for one program.

It is a fork behind the same walls, under the same limits, that runs no line of the program. The two have pipes between
them, which they have got before the program's first line (`child.course_channel`); calls and replies go there as plain
values. Here it is started at the first call, and asked how it ended: on its own wire, which the program cannot reach.
"""

from __future__ import annotations

import signal
from collections.abc import Callable

from server.sandbox import diagnosis
from server.sandbox.batch import random_token
from server.sandbox.child import codec, course_calls, frames
from server.sandbox.child.codec import Value
from server.sandbox.connection import EXIT_SECONDS, GRACE_SECONDS, ChildConnection, encode_configuration
from server.sandbox.course_pipes import CourseChannel
from server.sandbox.faults import FaultKind, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child, try_twice
from server.sandbox.values import Kit, encode_library
from server.sandbox.wire import DeadlineExceeded, ForgedAnswer, WireClosed

#: Calls of the course's functions that one execution of a program may make.
MAX_CALLS = 100_000
_ENDINGS = frozenset({frames.FAULT, frames.DONE})
#: Replies to calls that used up the process's own limits.
_REPLIES_AT_LIMITS = {
    FaultKind.TIMEOUT: codec.encode((course_calls.EXPIRED,), frames.ASK_LIMITS),
    FaultKind.MEMORY_LIMIT: course_calls.encode_raised(MemoryError()),
}


class CourseProcess(ChildConnection):
    """Holds the course's functions."""

    def __init__(self, child: Child, policy: Policy, on_failure: Callable[[], object]) -> None:
        """`on_failure` is told of a child that was not sound."""
        super().__init__(child, policy)
        self._on_failure = on_failure
        self._hold_token = random_token()

    def send_course_files(self, kit: Kit) -> None:
        """Send it the course's files. Raises TemplateFault when the child was not sound."""
        question: dict[str, Value] = {
            "library": encode_library(kit.sealed_files),
            "offered": kit.course_functions,
            "max_calls": MAX_CALLS,
        }
        configure, hold = random_token(), self._hold_token
        self._join_seat()
        try:
            self._expect_start_stage(0, frames.READY)
            self._send_setup(
                frames.pack_frame(configure, frames.CONFIGURE, encode_configuration(kit))
                + frames.pack_frame(hold, frames.HOLD, codec.encode(question, frames.QUESTION_LIMITS))
            )
            self._expect_start_stage(configure, frames.CONFIGURED)
            self._expect_start_stage(hold, frames.CONFIGURED)
        except TemplateFault:
            self._on_failure()
            raise

    def find_ending(self) -> bytes:
        """Return the reply to calls once the process has ended at a limit. Raises SandboxFault when it has failed.

        Raises ForgedAnswer when the program has ended its calls itself, or they have not ended at all: it has no
        business here then. Raises Abandoned.
        """
        fault = self._find_fault()
        reply = _REPLIES_AT_LIMITS.get(fault.kind) if fault else None
        if reply is None:
            raise SandboxFault(f"the course's functions failed: {fault}")
        return reply

    def _find_fault(self) -> ProgramFault | None:
        deadline = self._clock() + GRACE_SECONDS
        try:
            outcome, fault = self._child.wire.receive(self._hold_token, _ENDINGS, frames.FAULT_LIMITS.size, deadline)
        except (DeadlineExceeded, WireClosed):
            self._raise_if_abandoned()
            return self._find_exit_fault()
        if outcome == frames.DONE:
            raise ForgedAnswer
        return diagnosis.parse_fault(codec.decode(fault, frames.FAULT_LIMITS), self._policy)

    def _find_exit_fault(self) -> ProgramFault:
        """Return how a process that tells nothing has ended. Raises ForgedAnswer for one that still lives."""
        try:
            try:
                ending = self._child.wait_exit(GRACE_SECONDS)
            except TimeoutError:  # it lives, or the machine is too busy to tell its end: our own kill shows which
                self._child.kill()
                ending = self._child.wait_exit(EXIT_SECONDS)
                if ending.status == signal.SIGKILL:
                    raise ForgedAnswer from None
            return diagnosis.exit_fault(ending, self._policy)
        except (TemplateFault, TimeoutError) as error:
            raise SandboxFault(f"the process of the course's functions failed: {error!r}") from error

    def close(self) -> None:
        """End the process."""
        self._leave_seat()
        self._child.close()


class CourseCalls:
    """The process that one program calls: it starts at the first call, or is ordered before if calls are likely."""

    def __init__(self, kit: Kit, channel: CourseChannel, order: Callable[[CourseChannel], CourseProcess]) -> None:
        """`order` orders the process at the end of a channel, without waiting for it. Raises TemplateFault."""
        self._kit, self._channel, self._order = kit, channel, order
        self._process: CourseProcess | None = None
        self._ending = b""
        self.has_started = False

    def order(self) -> None:
        """Order the process. Raises TemplateFault."""
        self._process = self._order(self._channel)

    def answer(self) -> bytes:
        """Start the process for a program that makes its first call; say how it ended to one that asks again.

        Raises SandboxFault when we failed, ForgedAnswer when the program had no reason to ask.
        """
        if not self.has_started:
            try_twice(self._start)
            self.has_started = True
            return b""
        if self._process is None or self._ending:
            raise ForgedAnswer
        self._ending = self._process.find_ending()
        return self._ending

    def _start(self) -> None:
        process, self._process = self._process or self._order(self._channel), None
        try:
            process.send_course_files(self._kit)
        except BaseException:
            process.close()
            raise
        self._process = process
        self._channel.close()  # the program learns the end of its calls once nobody else has these ends

    def close(self) -> None:
        if self._process is not None:
            self._process.close()
