"""Recording of the calls that the checks of an exercise make of a trusted program, to make them again."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any

from graders.core.contract.local import LOCAL, LocalProgram
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    Program,
    Reply,
    call_batches_sequentially,
)
from graders.core.contract.values import Arguments, Value

#: Calls of one function that are recorded.
MAX_RECORDED_CALLS = 24


class CallRecorder:
    """Starts trusted files, and records the calls of some of their functions, at most `limit` of each on each map."""

    def __init__(self, functions: Collection[str], limit: int = MAX_RECORDED_CALLS) -> None:
        self._functions, self._limit = frozenset(functions), limit
        self._calls: dict[tuple[int, str], tuple[KitSettings, list[Arguments]]] = {}

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        return _RecordingProgram(LOCAL.open(source, kit), kit, self)

    def record_call(self, kit: KitSettings, function: str, args: Arguments) -> None:
        if function in self._functions:
            _, calls = self._calls.setdefault((id(kit), function), (kit, []))
            if len(calls) < self._limit:
                calls.append(args)

    def iter_calls_by_kit(self) -> Iterator[tuple[KitSettings, str, tuple[Arguments, ...]]]:
        for (_, function), (kit, calls) in self._calls.items():
            yield kit, function, tuple(calls)


class _RecordingProgram:
    """A program of `Recorder`."""

    def __init__(self, program: LocalProgram, kit: KitSettings, recorder: CallRecorder) -> None:
        self._program, self._kit, self._recorder = program, kit, recorder
        self.functions = program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        self._recorder.record_call(self._kit, function, args)
        return self._program.call(function, *args, return_arguments=return_arguments)

    def call_many(self, function: str, calls: Any, *, faults: int | None = None) -> Iterator[Answer]:
        noted = list(calls)
        for args in noted:
            self._recorder.record_call(self._kit, function, args)
        return self._program.call_many(function, noted, faults=faults)

    def call_batches(self, batches: Sequence[PlannedCalls]) -> Iterator[Block]:
        return call_batches_sequentially(self, batches)

    def stdout(self) -> str:
        return self._program.stdout()

    def close(self) -> None:
        self._program.close()
