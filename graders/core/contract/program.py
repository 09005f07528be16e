"""What a grader needs of a student's program: to start it, to call its functions, and nothing else.

The sandbox provides one implementation, `graders.core.contract.local` another, for our own code.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, runtime_checkable

from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Arguments, Value


@dataclass(frozen=True)
class KitSettings:
    """Which kit a program finds, and the parameters of this execution (map, range, seed).

    `without` are names of the kit that the exercise asks for: the program finds neither these nor what made them.
    """

    module: str
    parameters: Mapping[str, Value] = field(default_factory=dict)
    without: tuple[str, ...] = ()


class Reply(NamedTuple):
    """What a call returned and, where asked for, its arguments as they are afterwards."""

    value: Value
    arguments: tuple[Value, ...] | None = None


class StudentFault(Exception):
    """The student's program failed: by an exception, a limit, a forbidden operation, an unreadable answer.

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
#: Answers that have come together, one or more: all to the one of those asked that has this number.
Block = tuple[int, Sequence[Answer]]


@dataclass(frozen=True, eq=False)
class PlannedCalls:
    """Calls of one function that are made whatever is answered, so that they may be asked before their turn comes.

    None is made after `faults` faults (None: all are). With `keeping`, the arguments come back with each answer.
    `about` is what who asks wants to know of each call when its answer comes.
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
        """The answers of several calls, in order. A fault is the answer of its own call.

        Calls may be drawn and made ahead of the answers. None is made after a fatal fault, after `faults` faults, or
        where the function is missing: the last answer tells it.
        """
        ...

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        """The answers to several of these in order, each with the number of what has asked for it.

        Of each, those that `call_many` would give; none after a fatal fault, which comes alone.
        """
        ...

    def stdout(self) -> str: ...

    def close(self) -> None: ...


def flatten_blocks(blocks: Iterator[Block]) -> Iterator[tuple[int, Answer]]:
    """The answers one by one."""
    for number, answers in blocks:
        for answer in answers:
            yield number, answer


def call_batches_sequentially(program: Program, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
    """`Program.together` where nothing is won by it: each call is made when its answer is taken."""
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
    """`Program.call_many` where nothing is won by calling ahead: each call is made when its answer is taken."""
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
    """Programs that are started sooner where it is said before that they will be."""

    def prepare(self, source: bytes, kit: KitSettings, launches: int) -> None:
        """A file is about to be started so many times more."""
        ...


class Programs(Protocol):
    """Where the programs of files are started."""

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        """The program of a file, loaded with this kit. Raises StudentFault when the file does not load.

        What is asked `ahead`, which may be on its way with the file, is what `together` must be called with first.
        """
        ...
