"""The interface between graders and programs: start a program, call its functions, and nothing else.

The sandbox implements it for students' programs, `graders.core.contract.local` for trusted code.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, runtime_checkable

from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Arguments, Value


@dataclass(frozen=True)
class KitSettings:
    """The kit of a program and the parameters of this execution (map, range, seed).

    `without` are names of the kit that the exercise asks students to write, and that are hidden from the program.
    """

    module: str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    without: tuple[str, ...] = ()


class Reply(NamedTuple):
    """The value of a call and, on request, its arguments after the call.

    From the sandbox, the value of the call before in the same batch follows them, as it is by then.
    """

    value: Value
    arguments: tuple[Value, ...] | None = None


class StudentFault(Exception):
    """The student's program failed: an exception, a limit, a forbidden operation, an unreadable answer.

    `message` is French and meant for the student; `fatal` means that the process is gone.
    """

    def __init__(
        self,
        outcome: Outcome,
        message: str,
        *,
        line: int | None = None,
        frames: tuple[str, ...] = (),
        fatal: bool = False,
        exception: str | None = None,
    ) -> None:
        super().__init__(message)
        self.outcome = outcome
        self.message = message
        self.line = line
        self.frames = frames
        self.fatal = fatal
        self.exception = exception


Answer = Reply | StudentFault
#: One or more answers that arrived together, to the calls of the batch with this index.
Block = tuple[int, Sequence[Answer]]


@dataclass(frozen=True, eq=False)
class PlannedCalls:
    """A batch of calls of one function that do not depend on answers, so that they can be sent in advance.

    Calls stop after `faults` faults (None: never). With `return_arguments`, each reply holds the arguments after the
    call, then the value of the call before. `context` is data of the caller, one item a call.
    """

    function: str
    calls: Sequence[Arguments]
    faults: int | None = None
    return_arguments: bool = False
    context: Sequence[Any] = ()


class Program(Protocol):
    """A loaded program; calls are by position."""

    @property
    def functions(self) -> frozenset[str]: ...

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply: ...

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        """Yield the answers of several calls in order; a fault is the answer of its own call.

        Calls may be drawn and made ahead of the answers. They stop at a fatal fault, after `faults` faults, or where
        the function is missing; the last answer is then that fault.
        """
        ...

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        """Yield the answers to several batches in order, each block with the index of its batch.

        Each batch gets the answers of `call_many`; a fatal fault comes alone, and ends them all.
        """
        ...

    def stdout(self) -> str: ...

    def close(self) -> None: ...


def flatten_blocks(blocks: Iterator[Block]) -> Iterator[tuple[int, Answer]]:
    """Yield the answers one by one, with the index of their batch."""
    for number, answers in blocks:
        for answer in answers:
            yield number, answer


def call_batches_sequentially(program: Program, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
    """Implement `Program.call_batches` without pipelining: each call is made when its answer is taken."""
    for number, batch in enumerate(batches):
        for answer in call_sequentially(
            program, batch.function, batch.calls, batch.faults, return_arguments=batch.return_arguments
        ):
            yield number, (answer,)
            if isinstance(answer, StudentFault) and answer.fatal:
                return


def call_sequentially(
    program: Program,
    function: str,
    calls: Iterable[Arguments],
    faults: int | None = None,
    *,
    return_arguments: bool = False,
) -> Iterator[Answer]:
    """Implement `Program.call_many` without pipelining: each call is made when its answer is taken."""
    left = faults
    for args in calls:
        try:
            yield program.call(function, *args, return_arguments=return_arguments)
        except StudentFault as fault:
            yield fault
            left = None if left is None else left - 1
            if left == 0 or fault.fatal or fault.outcome is Outcome.MISSING_FUNCTION:
                return


@runtime_checkable
class PreparablePrograms(Protocol):
    """Programs that start faster when their launch is announced."""

    def prepare(self, source: bytes, kit: KitSettings, launches: int) -> None:
        """Announce further launches of a file."""
        ...


@runtime_checkable
class StoppablePrograms(Protocol):
    """Programs that may be stopped for a while."""

    def clock(self) -> float:
        """Return seconds, as `time.monotonic` does, without those for which the programs were stopped."""
        ...


class Programs(Protocol):
    """Starts the programs of files."""

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        """Load a file with this kit and return its program. Raises StudentFault when the file does not load.

        The batches `ahead` may travel with the file; `call_batches` must then be called with them first.
        """
        ...


def clock_of_programs(programs: Programs) -> Callable[[], float]:
    """Return the clock, in seconds, by which the time of these programs is bounded."""
    return programs.clock if isinstance(programs, StoppablePrograms) else time.monotonic
