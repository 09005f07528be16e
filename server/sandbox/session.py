"""One execution of a student's file, in one fork: questions, answers, and what went wrong in the student's words."""

from __future__ import annotations

import marshal
import re
import secrets
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from typing import Any, NoReturn, Self

import numpy as np

from server.sandbox import diagnosis, messages
from server.sandbox.batch import Batch, batches
from server.sandbox.child import codec, drawing, frames
from server.sandbox.child.codec import Value
from server.sandbox.faults import FaultKind, Frame, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child, Ending
from server.sandbox.values import Kit, Reply, Shelf, Usage
from server.sandbox.wire import Closed, Forged, Late, TooMuch

#: What the child is left to tell by itself that its time is up, before it is killed.
GRACE = 0.5
_READY_SECONDS = 10.0
_ENDING_SECONDS = 5.0
_NO_END = 1 << 31
_ANSWERS, _END = frozenset({frames.VALUE, frames.FAULT}), frozenset({frames.DONE})


@lru_cache(maxsize=64)
def _code(source: bytes) -> bytes:
    """A file of ours, compiled, without its comments and its texts of documentation."""
    return marshal.dumps(compile(source, "mes_fonctions.py", "exec", dont_inherit=True, optimize=2))


def _shelved(shelf: Shelf) -> Value:
    file = _code(shelf.source) if shelf.compiled else shelf.source
    return shelf.label, shelf.functions, np.frombuffer(file, dtype=np.uint8), shelf.compiled


class Session:
    """Made by `Sandbox.open`. Not for two threads at once."""

    def __init__(self, child: Child, policy: Policy) -> None:
        self._child, self._policy = child, policy
        self._waited = 0.0
        self._bytes_left, self._items_left = policy.session_bytes, policy.session_items
        self._filename, self._lines = "", [""]
        self._batch: Batch | None = None
        self._fatal: ProgramFault | None = None
        self._closed = False
        self._printed, self._cut = "", False
        self.functions: frozenset[str] = frozenset()

    def load(self, source: bytes, filename: str, kit: Kit | None, *, shows_last: bool = False) -> None:
        """Runs the file's top level. Raises TemplateFault when the child was not sound to begin with."""
        self._expect(0, frames.READY)
        self._configure(kit)
        self._filename, self._lines = filename, re.split("\r\n|\r|\n", source.decode("utf-8-sig", "replace"))
        question: dict[str, Value] = {"source": np.frombuffer(source, dtype=np.uint8), "filename": filename}
        question |= {"shows_last": shows_last, "library": tuple(map(_shelved, kit.library if kit else ()))}
        token = secrets.randbits(64)
        self._say(token, frames.LOAD, codec.encode(question | {"wall": self._left}, frames.QUESTION_LIMITS))
        functions = diagnosis.names(self._understood(*self._hear(token, _ANSWERS)))
        if functions is None:
            self._forged()
        self.functions = functions

    def _configure(self, kit: Kit | None) -> None:
        question: dict[str, Value] = {
            "kit": kit.module if kit else None,
            "parameters": dict(kit.parameters) if kit else {},
            "without": kit.without if kit else (),
        }
        token = secrets.randbits(64)
        try:
            deadline = time.monotonic() + _READY_SECONDS
            self._child.wire.ask(token, frames.CONFIGURE, codec.encode(question, frames.QUESTION_LIMITS), deadline)
        except (Late, Closed, Forged) as error:
            raise TemplateFault(f"a fork does not listen: {type(error).__name__}") from error
        self._expect(token, frames.CONFIGURED)

    def _expect(self, token: int, kind: int) -> None:
        """The child says that it has gone a step further, before any line of the student has run."""
        expected = frozenset({kind, frames.ANOMALY})
        try:
            came, said = self._child.wire.answer(token, expected, 1 << 16, time.monotonic() + _READY_SECONDS)
        except (Late, Closed, Forged) as error:
            raise TemplateFault(f"a fork did not come up: {type(error).__name__}") from error
        if came == frames.ANOMALY:
            raise TemplateFault(f"a fork failed: {said.decode('utf-8', 'replace')}")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the process. What it printed and what it used stay readable."""
        if not self._closed:
            self._closed = True
            self._child.kill()
            self._printed, self._cut = self._child.output.text(), self._child.output.truncated()
            self._child.close()

    def stdout(self) -> str:
        """What the program printed, up to the policy's bound."""
        return self._printed if self._closed else self._child.output.text()

    @property
    def stdout_truncated(self) -> bool:
        return self._cut if self._closed else self._child.output.truncated()

    @property
    def usage(self) -> Usage:
        """What the whole session used; closes it. Raises SandboxFault when nobody can tell."""
        self.close()
        try:
            ending = self._child.ending(_ENDING_SECONDS)
        except (TemplateFault, TimeoutError) as error:
            raise SandboxFault("nobody knows what the session used") from error
        return Usage(ending.cpu_seconds, self._waited, ending.max_rss_bytes)

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        """Calls a function of the student's file. Raises ProgramFault, or SandboxFault when the fault is ours."""
        answer = next(self.call_many(function, [args], return_arguments=return_arguments))
        if isinstance(answer, ProgramFault):
            raise answer
        return answer

    def call_many(
        self,
        function: str,
        calls: Iterable[tuple[Value, ...]],
        *,
        return_arguments: bool = False,
        faults: int | None = None,
    ) -> Iterator[Reply | ProgramFault]:
        """Calls a function with each tuple of arguments in turn, and gives each answer as it comes.

        Questions are sent ahead, in batches. A fault is the answer of its own call. There are fewer answers than calls
        after one that is fatal, after as many as `faults`, and where the function is missing: the program has then
        been asked no more, or has stopped by itself. An iterator that is left before its end lets the program finish
        its batch. Raises SandboxFault when the fault is ours.
        """
        self._must_be_open()
        if function in self.functions or self._fatal:
            asked = batches(function, calls, return_arguments=return_arguments)
            return self._answers(asked, _NO_END if faults is None else faults)
        message = messages.missing_function(function, self.functions)
        return iter((ProgramFault(FaultKind.MISSING_FUNCTION, messages.typeset(message)),))

    def figures(self) -> tuple[bytes, ...]:
        """What the program gives as the PNG files of its open figures: bytes of its own making, to be read with care.

        None where it does not draw. Raises as `call` does.
        """
        if drawing.FIGURES not in self.functions:
            return ()
        given = self.call(drawing.FIGURES).value
        if not isinstance(given, tuple) or len(given) > drawing.MAX_FIGURES:
            raise diagnosis.forged()
        pictures = tuple(
            array.tobytes() for array in given if isinstance(array, np.ndarray) and array.dtype == np.uint8
        )
        if len(pictures) != len(given) or any(len(picture) > drawing.MAX_BYTES for picture in pictures):
            raise diagnosis.forged()
        return pictures

    def _answers(self, asked: Iterable[Batch], faults: int) -> Iterator[Reply | ProgramFault]:
        try:
            for batch in asked:
                self._ask(batch, faults)
                while batch.waits:
                    answer = self._next(batch)
                    faults -= isinstance(answer, ProgramFault)
                    yield answer
                if batch.dropped:
                    raise SandboxFault("other questions have been asked since")
                if not faults:
                    return
        except ProgramFault as fatal:
            yield fatal
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _ask(self, batch: Batch, faults: int) -> None:
        """Sends a batch. What is left of one whose iterator was abandoned is read first, and dropped."""
        if self._fatal:
            raise self._fatal
        while self._batch is not None and self._batch.waits:
            self._batch.dropped = True
            self._next(self._batch)
        self._say(batch.token, frames.CALLS, batch.payload(self._left, faults))
        self._batch = batch

    def _next(self, batch: Batch) -> Reply | ProgramFault:
        """The next answer of a batch; raises a fault that is fatal. With the last one comes the end of the batch."""
        self._must_be_open()
        if self._fatal:
            raise self._fatal
        token, arguments = batch.next()
        answer: Reply | ProgramFault
        try:
            answer = self._reply(self._understood(*self._hear(token, _ANSWERS)), arguments)
        except ProgramFault as fault:
            if fault.fatal:
                raise
            answer = fault
            batch.fault()
        if not batch.waits:
            self._hear(batch.token, _END)
        return answer

    def _must_be_open(self) -> None:
        if self._closed:
            raise SandboxFault("the session is closed")

    def _reply(self, answer: Value, expected: int | None) -> Reply:
        if not isinstance(answer, tuple) or len(answer) != 2:
            self._forged()
        value, arguments = answer
        sound = arguments is None if expected is None else isinstance(arguments, tuple) and len(arguments) == expected
        if not sound:
            self._forged()
        return Reply(value, arguments if isinstance(arguments, tuple) else None)

    @property
    def _left(self) -> float:
        return max(self._policy.wall_seconds - self._waited, 0.001)

    def _say(self, token: int, kind: int, payload: bytes) -> None:
        with self._counted() as deadline:
            self._child.wire.ask(token, kind, payload, deadline)

    def _hear(self, token: int, kinds: frozenset[int]) -> tuple[int, bytes]:
        with self._counted() as deadline:
            kind, payload = self._child.wire.answer(token, kinds, self._policy.frame_bytes, deadline, self._bytes_left)
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
        limits = self._policy.answer
        try:
            value, items = codec.measured(answer, replace(limits, items=min(limits.items, self._items_left)))
        except codec.TooMany:
            if self._items_left >= limits.items:
                raise
            self._end(lambda _: diagnosis.too_much("items", self._policy))
        self._items_left -= items
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
            ending = self._child.ending(_ENDING_SECONDS)
        except TimeoutError as error:
            raise TemplateFault("a child cannot be killed") from error
        self._fatal = fault(ending)
        raise self._fatal
