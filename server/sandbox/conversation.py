"""One child's answers, as they are heard: in their turn, within the bounds of its policy; or how it has ended."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, NoReturn

from server.sandbox import diagnosis
from server.sandbox.alike import Alike
from server.sandbox.batch import token
from server.sandbox.child import codec, frames
from server.sandbox.child.codec import Value
from server.sandbox.faults import Frame, ProgramFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child, Ending
from server.sandbox.wire import Closed, Forged, Late, TooMuch

#: What the child is left to tell by itself that its time is up, before it is killed.
GRACE = 0.5
ENDING_SECONDS = 5.0
_READY_SECONDS = 10.0


class Conversation:
    """Counts the time that is waited for a child, and what its answers hold; ends one that goes beyond, or forges."""

    def __init__(self, child: Child, policy: Policy) -> None:
        self._child, self._policy = child, policy
        self._waited = 0.0
        self._bytes_left, self._items_left = policy.session_bytes, policy.session_items
        self._filename, self._lines = "", [""]
        self._alike = Alike()
        self._fatal: ProgramFault | None = None

    def _begin(self, questions: bytes) -> None:
        try:
            self._child.wire.ask(token(), frames.TOGETHER, questions, time.monotonic() + _READY_SECONDS)
        except (Late, Closed, Forged) as error:
            raise TemplateFault(f"a fork does not listen: {type(error).__name__}") from error

    def _expect(self, called: int, kind: int) -> None:
        """The child says that it has gone a step further, before any line of the student has run."""
        expected = frozenset({kind, frames.ANOMALY})
        try:
            came, said = self._child.wire.answer(called, expected, 1 << 16, time.monotonic() + _READY_SECONDS)
        except (Late, Closed, Forged) as error:
            raise TemplateFault(f"a fork did not come up: {type(error).__name__}") from error
        if came == frames.ANOMALY:
            raise TemplateFault(f"a fork failed: {said.decode('utf-8', 'replace')}")

    @property
    def _left(self) -> float:
        return max(self._policy.wall_seconds - self._waited, 0.001)

    def _say(self, questions: bytes) -> None:
        with self._counted() as deadline:
            self._child.wire.ask(token(), frames.TOGETHER, questions, deadline)

    def _hear(self, called: int, kinds: frozenset[int]) -> tuple[int, bytes]:
        """The next frame. What is here already is not waited for, and takes no time."""
        wire, limit = self._child.wire, self._policy.frame_bytes
        if wire.holds:
            try:
                kind, payload = wire.answer(called, kinds, limit, 0.0, self._bytes_left)
            except Forged:
                self._forged()
            except TooMuch:
                self._end(lambda _: diagnosis.too_much("bytes", self._policy))
        else:
            with self._counted() as deadline:
                kind, payload = wire.answer(called, kinds, limit, deadline, self._bytes_left)
        self._bytes_left -= len(payload)
        return kind, payload

    @contextmanager
    def _counted(self) -> Iterator[float]:
        """Counts the time spent with the wire, and ends a session that has no more of it or that plays with it."""
        start = time.monotonic()
        try:
            yield start + self._left + GRACE
        except Late:
            self._end(lambda _: diagnosis.late(self._policy, self._last_frames()))
        except Forged:
            self._forged()
        except TooMuch:
            self._end(lambda _: diagnosis.too_much("bytes", self._policy))
        except Closed:
            self._died()
        finally:
            self._waited += time.monotonic() - start

    def _understood(self, outcome: int, answer: bytes) -> Value:
        try:
            if outcome == frames.VALUE:
                return self._value(answer)
            fault: Any = codec.decode(answer, frames.FAULT_LIMITS)
        except codec.Malformed:
            self._forged()
        program_fault = diagnosis.told(fault, self._policy)
        if program_fault is None:
            self._forged()
        if program_fault.fatal:
            self._end(lambda _: program_fault)
        raise program_fault

    def _value(self, answer: bytes) -> Value:
        """Raises Malformed, or the fault of a program that has answered too much in all."""
        alike = self._alike.read(answer)
        if alike is not None and self._alike.items <= self._items_left:
            self._items_left -= self._alike.items
            return alike, None
        limits = self._policy.answer
        if self._items_left < limits.items:
            limits = replace(limits, items=self._items_left)
        try:
            value, items = codec.measured(answer, limits)
        except codec.TooMany:
            if self._items_left >= self._policy.items:
                raise
            self._end(lambda _: diagnosis.too_much("items", self._policy))
        self._items_left -= items
        self._alike.learn(answer, value, items)
        return value

    def _died(self) -> NoReturn:
        """The wire is closed: the process has ended by itself, or it has closed the wire and lives on."""
        try:
            self._child.ending(GRACE)
        except TimeoutError:  # it lives on, or the machine is too busy to tell its end: only our own kill shows which
            self._end(self._killed_or_ended)
        self._end(self._ended)

    def _killed_or_ended(self, ending: Ending) -> ProgramFault:
        return diagnosis.forged() if ending.status == signal.SIGKILL else self._ended(ending)

    def _ended(self, ending: Ending) -> ProgramFault:
        return diagnosis.ended(ending, self._policy, self._last_frames())

    def _last_frames(self) -> tuple[Frame, ...]:
        return diagnosis.last_frames(self._child.output.last_words(), self._filename, self._lines)

    def _forged(self) -> NoReturn:
        self._end(lambda _: diagnosis.forged())

    def _end(self, fault: Callable[[Ending], ProgramFault]) -> NoReturn:
        """Ends the process, then raises the fault that its ending tells; later calls raise it again."""
        self._child.kill()
        try:
            ending = self._child.ending(ENDING_SECONDS)
        except TimeoutError as error:
            raise TemplateFault("a child cannot be killed") from error
        self._fatal = fault(ending)
        raise self._fatal
