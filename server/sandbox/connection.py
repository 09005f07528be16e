"""Receives one child's answers within the bounds of its policy, or finds out how the child ended."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NoReturn, Protocol

from server.sandbox import diagnosis
from server.sandbox.answer_shape import AnswerShape
from server.sandbox.batch import random_token
from server.sandbox.child import codec, frames
from server.sandbox.child.codec import Value
from server.sandbox.course_pipes import CourseChannel
from server.sandbox.faults import Frame, ProgramFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child, ChildExit
from server.sandbox.seat import current_seat, seat_clock
from server.sandbox.values import Kit
from server.sandbox.wire import AnswerBudgetExceeded, DeadlineExceeded, ForgedAnswer, WireClosed

#: Seconds that a child gets to report its own timeout before it is killed.
GRACE_SECONDS = 0.5
EXIT_SECONDS = 5.0
_READY_SECONDS = 10.0
_ASK = frozenset({frames.ASK})


class CourseFunctionCalls(Protocol):
    """Has functions of the course called (`server.sandbox.course_process.CourseCalls`)."""

    has_started: bool

    def answer(self) -> bytes: ...

    def close(self) -> None: ...


def encode_configuration(kit: Kit | None) -> bytes:
    """Encode the question that configures a child's kit."""
    question: dict[str, Value] = {
        "kit": kit.module if kit else None,
        "parameters": dict(kit.parameters) if kit else {},
        "without": kit.without if kit else (),
    }
    return codec.encode(question, frames.QUESTION_LIMITS)


class ChildConnection:
    """Accounts for waiting time and answer sizes of a child; terminates one that exceeds its budgets or forges.

    It is one of the programs of its thread's seat, if that has one, and the seat's clock is its own.
    """

    def __init__(self, child: Child, policy: Policy) -> None:
        self._child, self._policy, self._seat = child, policy, current_seat()
        self._clock = seat_clock()
        child.wire.clock = self._clock
        self._waited, self._deadline = 0.0, 0.0
        self._bytes_left, self._items_left = policy.session_bytes, policy.session_items
        self._filename, self._lines = "", [""]
        self._answer_shape = AnswerShape()
        self._fatal: ProgramFault | None = None
        #: The program's calls of the course's functions, where it may make some.
        self.course_calls: CourseFunctionCalls | None = None

    def _join_seat(self) -> None:
        """Become one of the programs of the seat. Raises Abandoned."""
        if self._seat:
            self._seat.add(self)

    def _leave_seat(self) -> None:
        if self._seat:
            self._seat.remove(self)

    def _raise_if_abandoned(self) -> None:
        if self._seat:
            self._seat.raise_if_abandoned()

    def stop(self) -> None:
        """Stop the process; the clock of its seat stands still."""
        self._child.stop()

    def go_on(self) -> None:
        """Let the process go on, with as much time as it had left."""
        left = self._deadline - self._clock()  # none before the trusted side has begun to wait
        self._child.go_on(time.monotonic() + (left if left > 0 else self._seconds_left))

    def kill(self) -> None:
        """End the process; whoever waits for it learns so."""
        self._child.kill()

    @property
    def course_channel(self) -> CourseChannel:
        """The far end of the child's calls of the course's functions."""
        return self._child.channel

    def _send_setup(self, questions: bytes) -> None:
        try:
            self._child.wire.send(random_token(), frames.TOGETHER, questions, self._clock() + _READY_SECONDS)
        except (DeadlineExceeded, WireClosed, ForgedAnswer) as error:
            self._raise_if_abandoned()
            raise TemplateFault(f"a fork does not listen: {type(error).__name__}") from error

    def _expect_start_stage(self, called: int, kind: int) -> None:
        """Wait for the child to report a stage of its start, before any line of the student runs."""
        expected = frozenset({kind, frames.ANOMALY})
        try:
            came, said = self._child.wire.receive(called, expected, 1 << 16, self._clock() + _READY_SECONDS)
        except (DeadlineExceeded, WireClosed, ForgedAnswer) as error:
            self._raise_if_abandoned()
            raise TemplateFault(f"a fork did not come up: {type(error).__name__}") from error
        if came == frames.ANOMALY:
            raise TemplateFault(f"a fork failed: {said.decode('utf-8', 'replace')}")

    @property
    def _seconds_left(self) -> float:
        """Time left to the child: once a program calls the course, it counts its own, and has as much again there."""
        parts = 2 if self.course_calls is not None and self.course_calls.has_started else 1
        return max(parts * self._policy.wall_seconds - self._waited, 0.001)

    def _send_frames(self, questions: bytes) -> None:
        with self._account_for_wire_time() as deadline:
            self._child.wire.send(random_token(), frames.TOGETHER, questions, deadline)

    def _receive(self, called: int, kinds: frozenset[int]) -> tuple[int, bytes]:
        """Return kind and payload of the next frame; meanwhile, have the course's functions ready for calls."""
        if self.course_calls is None:
            return self._receive_frame(called, kinds)
        while (came := self._receive_frame(called, kinds | _ASK))[0] == frames.ASK:
            try:
                reply = self.course_calls.answer()
            except ForgedAnswer:
                self._raise_forged()
            with self._account_for_wire_time() as deadline:
                self._child.wire.reply(called, frames.VALUE, reply, deadline)
        return came

    def _receive_frame(self, called: int, kinds: frozenset[int]) -> tuple[int, bytes]:
        """Return kind and payload of the next frame; a frame that is here already costs no waiting time."""
        wire, limit = self._child.wire, self._policy.frame_bytes
        if wire.has_whole_answer:
            try:
                kind, payload = wire.receive(called, kinds, limit, 0.0, self._bytes_left)
            except ForgedAnswer:
                self._raise_forged()
            except AnswerBudgetExceeded:
                self._terminate(lambda _: diagnosis.answers_too_big_fault("bytes", self._policy))
        else:
            with self._account_for_wire_time() as deadline:
                kind, payload = wire.receive(called, kinds, limit, deadline, self._bytes_left)
        self._bytes_left -= len(payload)
        return kind, payload

    @contextmanager
    def _account_for_wire_time(self) -> Iterator[float]:
        """Account for the time spent on the wire; terminate the child when it runs out of time or forges."""
        start = self._clock()
        self._deadline = start + self._seconds_left
        try:
            yield self._deadline + GRACE_SECONDS
        except DeadlineExceeded:
            self._terminate(lambda _: diagnosis.wall_timeout_fault(self._policy, self._last_frames()))
        except ForgedAnswer:
            self._raise_forged()
        except AnswerBudgetExceeded:
            self._terminate(lambda _: diagnosis.answers_too_big_fault("bytes", self._policy))
        except WireClosed:
            self._raise_wire_closed()
        finally:
            self._waited += self._clock() - start

    def _decode_outcome(self, outcome: int, answer: bytes) -> Value:
        try:
            if outcome == frames.VALUE:
                return self._decode_value(answer)
            fault: Any = codec.decode(answer, frames.FAULT_LIMITS)
        except codec.MalformedValue:
            self._raise_forged()
        program_fault = diagnosis.parse_fault(fault, self._policy, self._lines)
        if program_fault is None:
            self._raise_forged()
        if program_fault.fatal:
            self._terminate(lambda _: program_fault)
        raise program_fault

    def _decode_value(self, answer: bytes) -> Value:
        """Decode an answer within the session's budgets. Raises MalformedValue; terminates a child over budget."""
        alike = self._answer_shape.read(answer)
        if alike is not None and self._answer_shape.items <= self._items_left:
            self._items_left -= self._answer_shape.items
            return alike, None
        limits = self._policy.answer_limits
        if self._items_left < limits.items:
            limits = replace(limits, items=self._items_left)
        try:
            value, items = codec.decode_counted(answer, limits)
        except codec.TooManyItems:
            if self._items_left >= self._policy.items:
                raise
            self._terminate(lambda _: diagnosis.answers_too_big_fault("items", self._policy))
        self._items_left -= items
        self._answer_shape.learn(answer, value, items)
        return value

    def _raise_wire_closed(self) -> NoReturn:
        """Handle a closed wire: the process ended by itself, or closed the wire and lives on. Raises Abandoned."""
        self._raise_if_abandoned()
        try:
            self._child.wait_exit(GRACE_SECONDS)
        except TimeoutError:  # it lives on, or the machine is too busy to tell its end: only our own kill shows which
            self._terminate(self._forged_or_exit_fault)
        self._terminate(self._exit_fault)

    def _forged_or_exit_fault(self, ending: ChildExit) -> ProgramFault:
        return diagnosis.forged_answer_fault() if ending.status == signal.SIGKILL else self._exit_fault(ending)

    def _exit_fault(self, ending: ChildExit) -> ProgramFault:
        return diagnosis.exit_fault(ending, self._policy, self._last_frames())

    def _last_frames(self) -> tuple[Frame, ...]:
        return diagnosis.parse_last_frames(self._child.output.crash_traceback(), self._filename, self._lines)

    def _raise_forged(self) -> NoReturn:
        self._terminate(lambda _: diagnosis.forged_answer_fault())

    def _terminate(self, fault: Callable[[ChildExit], ProgramFault]) -> NoReturn:
        """Kill the process, then raise the fault that its exit shows; later calls raise it again."""
        self._child.kill()
        try:
            ending = self._child.wait_exit(EXIT_SECONDS)
        except TimeoutError as error:
            raise TemplateFault("a child cannot be killed") from error
        self._fatal = fault(ending)
        raise self._fatal
