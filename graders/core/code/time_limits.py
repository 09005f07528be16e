"""Programs that are asked nothing more once the time of a search is spent, whichever step it is in."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

from graders.core.code.pair_search import OutOfTimeError
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    PreparablePrograms,
    Program,
    Programs,
    Reply,
)
from graders.core.contract.values import Arguments, Value


@dataclass(frozen=True)
class TimeLimitedPrograms:
    """Starts programs until the time is spent; then each launch, call or further answer raises OutOfTimeError."""

    programs: Programs
    is_time_spent: Callable[[], bool]

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        _raise_if_spent(self.is_time_spent)
        return _TimeLimitedProgram(self.programs.open(source, kit, ahead), self.is_time_spent)

    def prepare(self, source: bytes, kit: KitSettings, launches: int) -> None:
        if isinstance(self.programs, PreparablePrograms):
            self.programs.prepare(source, kit, launches)


@dataclass(frozen=True)
class _TimeLimitedProgram:
    program: Program
    is_time_spent: Callable[[], bool]

    @property
    def functions(self) -> frozenset[str]:
        return self.program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        _raise_if_spent(self.is_time_spent)
        return self.program.call(function, *args, return_arguments=return_arguments)

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        _raise_if_spent(self.is_time_spent)
        for answer in self.program.call_many(function, calls, faults=faults):
            yield answer
            _raise_if_spent(self.is_time_spent)

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        _raise_if_spent(self.is_time_spent)
        for block in self.program.call_batches(batches):
            yield block
            _raise_if_spent(self.is_time_spent)

    def stdout(self) -> str:
        return self.program.stdout()

    def close(self) -> None:
        self.program.close()


def _raise_if_spent(is_time_spent: Callable[[], bool]) -> None:
    if is_time_spent():
        raise OutOfTimeError
