"""What a grader needs of a student's program: to call its functions, and nothing else.

The sandbox provides one implementation; `LocalProgram` runs our own code (references, misconceptions) in process.
"""

from __future__ import annotations

import copy
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Protocol

from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Arguments, Value

PROJECT = Path(__file__).resolve().parents[3]


@dataclass(frozen=True)
class KitSettings:
    """Which kit a program finds, and the parameters of this execution (map, range, seed)."""

    module: str
    parameters: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class Reply:
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

    def stdout(self) -> str: ...

    def close(self) -> None: ...


def one_by_one(
    program: Program, function: str, calls: Iterable[Arguments], faults: int | None = None
) -> Iterator[Answer]:
    """`Program.call_many` where nothing is won by calling ahead: each call is made when its answer is taken."""
    left = faults
    for args in calls:
        try:
            yield program.call(function, *args)
        except StudentFault as fault:
            yield fault
            left = None if left is None else left - 1
            if left == 0 or fault.fatal or fault.outcome is Outcome.MISSING_FUNCTION:
                return


Launcher = Callable[[KitSettings], Program]


@cache
def kit_source(module: str) -> str:
    """The source of a module's kit, as students can read it."""
    return (PROJECT / "curriculum" / module / "kit" / f"{module}.py").read_text(encoding="utf-8")


@cache
def _compiled(source: str, name: str) -> types.CodeType:
    return compile(source, name, "exec", dont_inherit=True)


@cache
def _kit(module: str) -> dict[str, Any]:
    """The names of a module's kit: `configurer` makes new ones for each program."""
    names: dict[str, Any] = {"__name__": module}
    exec(_compiled(kit_source(module), f"<kit {module}>"), names)
    return names


class LocalProgram:
    """Run trusted code in this process, with the same kit and the same interface as a student's program."""

    def __init__(self, source: str, kit: KitSettings) -> None:
        self._names: dict[str, Any] = {"__name__": "solution", **_kit(kit.module)["configurer"](**kit.parameters)}
        before = set(self._names)
        exec(_compiled(source, "<trusted>"), self._names)
        self.functions = frozenset(n for n in self._names if n not in before and callable(self._names[n]))

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        """Call a function on copies of the arguments. Its exceptions become a StudentFault, as in the sandbox."""
        if function not in self.functions:
            raise StudentFault(Outcome.MISSING_FUNCTION, f"la fonction {function} n'est pas définie")
        given = tuple(copy.deepcopy(arg) for arg in args)
        try:
            value = self._names[function](*given)
        except Exception as error:
            message = f"{type(error).__name__} : {error}"
            raise StudentFault(Outcome.RUNTIME_ERROR, message, exception=type(error).__name__) from error
        return Reply(copy.deepcopy(value), given if return_arguments else None)

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        return one_by_one(self, function, calls, faults)

    def stdout(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing to give back."""


def local_launcher(source: str) -> Launcher:
    """A launcher of trusted code."""
    return lambda kit: LocalProgram(source, kit)
