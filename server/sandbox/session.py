"""One execution of a student's file, in one fork: questions, answers, and what went wrong in the student's words."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from typing import Any, NoReturn, Self

import numpy as np

from server.sandbox import diagnosis, messages
from server.sandbox.child import codec, frames
from server.sandbox.child.codec import Value
from server.sandbox.faults import FaultKind, ProgramFault, SandboxFault, TemplateFault
from server.sandbox.policy import Policy
from server.sandbox.process import Child, Ending
from server.sandbox.values import Kit, Reply, Usage
from server.sandbox.wire import Closed, Forged, Late

#: What the child is left to tell by itself that its time is up, before it is killed.
GRACE = 0.5
_READY_SECONDS = 10.0
_ENDING_SECONDS = 5.0
_QUESTION = codec.Limits(size=1 << 28, depth=64, items=10_000_000)
_FAULT = codec.Limits(size=1 << 16, depth=8, items=1000)
_ANSWERS = frozenset({frames.VALUE, frames.FAULT})


class Session:
    """Made by `Sandbox.open`. Not for two threads at once."""

    def __init__(self, child: Child, policy: Policy) -> None:
        self._child, self._policy = child, policy
        self._waited = 0.0
        self._fatal: ProgramFault | None = None
        self._closed = False
        self._printed, self._cut = "", False
        self.functions: frozenset[str] = frozenset()

    def load(self, source: bytes, filename: str, kit: Kit | None) -> None:
        """Runs the file's top level. Raises TemplateFault when the child was not sound to begin with."""
        self._expect(0, frames.READY)
        self._configure(kit)
        question: dict[str, Value] = {"source": np.frombuffer(source, dtype=np.uint8), "filename": filename}
        functions = diagnosis.names(self._exchange(frames.LOAD, question))
        if functions is None:
            self._forged()
        self.functions = functions

    def _configure(self, kit: Kit | None) -> None:
        question: dict[str, Value] = {
            "kit": kit.module if kit else None,
            "parameters": dict(kit.parameters) if kit else {},
        }
        token = secrets.randbits(64)
        try:
            deadline = time.monotonic() + _READY_SECONDS
            self._child.wire.ask(token, frames.CONFIGURE, codec.encode(question, _QUESTION), deadline)
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
        if self._closed:
            raise SandboxFault("the session is closed")
        if self._fatal:
            raise self._fatal
        if function not in self.functions:
            message = messages.missing_function(function, self.functions)
            raise ProgramFault(FaultKind.MISSING_FUNCTION, messages.typeset(message))
        question: dict[str, Value] = {"function": function, "arguments": args, "return_arguments": return_arguments}
        try:
            return self._reply(self._exchange(frames.CALL, question), len(args) if return_arguments else None)
        except TemplateFault as error:
            raise SandboxFault(str(error)) from error

    def _reply(self, answer: Value, expected: int | None) -> Reply:
        if not isinstance(answer, tuple) or len(answer) != 2:
            self._forged()
        value, arguments = answer
        sound = arguments is None if expected is None else isinstance(arguments, tuple) and len(arguments) == expected
        if not sound:
            self._forged()
        return Reply(value, arguments if isinstance(arguments, tuple) else None)

    def _exchange(self, kind: int, question: dict[str, Value]) -> Value:
        left = max(self._policy.wall_seconds - self._waited, 0.001)
        payload = codec.encode(question | {"wall": left}, _QUESTION)
        token = secrets.randbits(64)
        start = time.monotonic()
        try:
            self._child.wire.ask(token, kind, payload, start + left + GRACE)
            limit = self._policy.frame_bytes
            outcome, answer = self._child.wire.answer(token, _ANSWERS, limit, start + left + GRACE)
        except Late:
            self._end(lambda _: diagnosis.late(self._policy))
        except Forged:
            self._forged()
        except Closed:
            self._died()
        finally:
            self._waited += time.monotonic() - start
        return self._understood(outcome, answer)

    def _understood(self, outcome: int, answer: bytes) -> Value:
        try:
            if outcome == frames.VALUE:
                return codec.decode(answer, self._policy.answer)
            fault: Any = codec.decode(answer, _FAULT)
        except codec.Malformed:
            self._forged()
        told = diagnosis.told(fault, self._policy)
        if told is None:
            self._forged()
        if told.fatal:
            self._end(lambda _: told)
        raise told

    def _died(self) -> NoReturn:
        """The wire is closed: the process has ended by itself, or it has closed the wire and lives on."""
        try:
            self._child.ending(GRACE)
        except TimeoutError:
            self._forged()
        self._end(lambda ending: diagnosis.ended(ending, self._policy))

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
