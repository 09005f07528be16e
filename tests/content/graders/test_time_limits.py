"""Each step of a search beside right functions obeys the time, by a clock of exchanges."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from graders.core.code.isolation import isolate_failed_functions, name_mistakes_in_time
from graders.core.contract.local import LOCAL, LocalProgram
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    Reply,
    call_batches_sequentially,
    call_sequentially,
)
from graders.core.contract.values import Value
from tests.support.shipped import CODE


class _Counting:
    """Starts trusted files, and counts the launches and the exchanges."""

    def __init__(self) -> None:
        self.made = 0

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> _CountedProgram:
        self.made += 1
        return _CountedProgram(LOCAL.open(source, kit), self)


class _CountedProgram:
    def __init__(self, program: LocalProgram, counting: _Counting) -> None:
        self._program, self._counting, self.functions = program, counting, program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        self._counting.made += 1
        return self._program.call(function, *args, return_arguments=return_arguments)

    def call_many(self, function: str, calls: Any, *, faults: int | None = None) -> Iterator[Answer]:
        return call_sequentially(self, function, calls, faults)

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        return call_batches_sequentially(self, batches)

    def stdout(self) -> str:
        return ""

    def close(self) -> None:
        """Nothing to give back."""


def test_each_step_beside_right_functions_obeys_the_time() -> None:
    """By a clock of exchanges, each of which takes one unit: none is made once the time is spent."""
    grader, counting = CODE["l19/gain"], _Counting()
    source = grader.solution.replace("return", "return 2 *", 1)
    found = isolate_failed_functions(grader, source, counting, 3, lambda: False)
    assert found is not None
    whole = counting.made
    for allowed in (1, 2, whole // 4, whole // 2, whole - 1):
        counting.made = 0
        assert isolate_failed_functions(grader, source, counting, 3, lambda left=allowed: counting.made >= left) is None
        assert counting.made == allowed


def test_naming_in_a_whole_program_obeys_the_time() -> None:
    grader, counting = CODE["l20/kabsch"], _Counting()
    source = next(each.source for each in grader.misconceptions if each.id == "t_oppose")
    assert name_mistakes_in_time(grader, source, counting, 3, lambda: False).ids == ("t_oppose",)
    counting.made = 0
    assert name_mistakes_in_time(grader, source, counting, 3, lambda: counting.made >= 2).ids == ()
    assert counting.made == 2
