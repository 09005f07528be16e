"""Finds the call of a failed check again: runs the check once more and records its calls.

A check draws its inputs from the seed of its grading: run again on the same program, it reaches the same case. A
verdict holds a readable form of that case; the replay needs the exact values.
"""

from __future__ import annotations

import copy
import json
import math
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection
from graders.core.code.exercise import CodeDefinition
from graders.core.code.runner import Runner
from graders.core.code.simplifying import run_and_shrink
from graders.core.compare.shrinking import Budget
from graders.core.compare.words import to_jsonable
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import (
    Answer,
    Block,
    KitSettings,
    PlannedCalls,
    Program,
    Programs,
    Reply,
    StudentFault,
)
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments, Value

#: Seconds for finding the call.
MAX_SECONDS = 8.0
#: Number of last calls whose answers are remembered.
MAX_REMEMBERED_CALLS = 500
#: The counterexample is simplified as far as in the grading, on a slower machine too: the search has its own end.
_ANY_PACE = Budget(seconds=math.inf)
_TIMED_OUT = "La recherche de ce cas a pris trop de temps."


@dataclass(frozen=True)
class ReplayCase:
    """A call, its kit settings, and its reply; None for a fault."""

    function: str
    arguments: Arguments
    kit: KitSettings
    reply: Reply | None


def find_replay_case(
    definition: CodeDefinition,
    check_id: str,
    inputs: Mapping[str, Any],
    source: bytes,
    programs: Programs,
    *,
    seed: int,
) -> ReplayCase | None:
    """Find the call whose arguments a verdict shows as `inputs`; None where the check no longer makes it."""
    check = next((candidate for candidate in definition.checks if candidate.id == check_id), None)
    if check is None:
        return None
    kit = definition.kit(stream(seed, "kit"))
    recorder = _RecordingPrograms(programs, inputs)
    runner = Runner(recorder, source, kit, budget=_ANY_PACE)
    try:
        _run_recorded_check(check, Bench(check.id, runner, stream(seed, check.id), kit), recorder)
    except StudentFault:
        pass
    finally:
        runner.close()
    return recorder.case


def _run_recorded_check(check: Check, bench: Bench, recorder: _RecordingPrograms) -> None:
    try:
        run_and_shrink(check.run, bench)
    except Rejection as rejection:
        if rejection.call is not None and _shows_same_inputs(rejection.inputs or {}, recorder.inputs):
            recorder.set_rejected_case(*rejection.call)


def _shows_same_inputs(inputs: Mapping[str, Value], shown: Mapping[str, Any]) -> bool:
    return {name: to_jsonable(value) for name, value in inputs.items()} == shown


@dataclass(frozen=True)
class _AnsweredCall:
    function: str
    arguments: Arguments
    reply: Reply | None

    def is_call_with(self, function: str, arguments: Arguments) -> bool:
        """Whether it is the call with these very objects."""
        pairs = zip(self.arguments, arguments, strict=False)
        return (self.function, len(self.arguments)) == (function, len(arguments)) and all(a is b for a, b in pairs)


class _RecordingPrograms:
    """Starts programs that compare each call with the inputs of a verdict; `case` is the last equal call."""

    def __init__(self, programs: Programs, inputs: Mapping[str, Any]) -> None:
        self.inputs = dict(inputs)
        self.case: ReplayCase | None = None
        self._programs = programs
        self._sought = sorted(map(_json_sort_key, inputs.values()))
        self._until = time.monotonic() + MAX_SECONDS
        self._kit: KitSettings | None = None
        self.answered_calls: deque[_AnsweredCall] = deque(maxlen=MAX_REMEMBERED_CALLS)

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        self.require_time()
        return _RecordingProgram(self._programs.open(source, kit, ahead), kit, self)

    def require_time(self) -> None:
        """Raise StudentFault, which ends the check, once it takes too long."""
        if time.monotonic() > self._until:
            raise StudentFault(Outcome.TIMEOUT, _TIMED_OUT, fatal=True)

    def match_call(self, function: str, arguments: Arguments, kit: KitSettings) -> ReplayCase | None:
        """Return the call as a case if it is the one sought, with a copy of its arguments."""
        self._kit = kit
        if (
            len(arguments) != len(self._sought)
            or sorted(_json_sort_key(to_jsonable(value)) for value in arguments) != self._sought
        ):
            return None
        return ReplayCase(function, copy.deepcopy(arguments), kit, None)

    def set_rejected_case(self, function: str, arguments: Arguments) -> None:
        """Record the call that the check itself reports."""
        assert self._kit is not None, "a rejected call was made"
        answers = (call.reply for call in reversed(self.answered_calls) if call.is_call_with(function, arguments))
        self.case = ReplayCase(function, arguments, self._kit, next(answers, None))


class _RecordingProgram:
    def __init__(self, program: Program, kit: KitSettings, recorder: _RecordingPrograms) -> None:
        self._program, self._kit, self._recorder = program, kit, recorder

    @property
    def functions(self) -> frozenset[str]:
        return self._program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        self._recorder.require_time()
        case = self._recorder.match_call(function, args, self._kit)
        self._recorder.case = case or self._recorder.case
        reply = self._program.call(function, *args, return_arguments=return_arguments)
        self._recorder.answered_calls.append(_AnsweredCall(function, args, reply))
        if case is not None:
            self._recorder.case = ReplayCase(case.function, case.arguments, case.kit, reply)
        return reply

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        pending: deque[tuple[Arguments, ReplayCase | None]] = deque()

        def recorded() -> Iterator[Arguments]:
            for arguments in calls:
                pending.append((arguments, self._recorder.match_call(function, arguments, self._kit)))
                yield arguments

        for answer in self._program.call_many(function, recorded(), faults=faults):
            self._record_answer(function, pending, answer)
            yield answer

    def call_batches(self, asked: Sequence[PlannedCalls]) -> Iterator[Block]:
        pending = [
            deque((args, self._recorder.match_call(batch.function, args, self._kit)) for args in batch.calls)
            for batch in asked
        ]
        for number, answers in self._program.call_batches(asked):
            for answer in answers:
                self._record_answer(asked[number].function, pending[number], answer)
            yield number, answers

    def _record_answer(
        self, function: str, pending: deque[tuple[Arguments, ReplayCase | None]], answer: Answer
    ) -> None:
        """Record the answer to the first pending call."""
        self._recorder.require_time()
        if not pending:
            return
        arguments, case = pending.popleft()
        reply = answer if isinstance(answer, Reply) else None
        self._recorder.answered_calls.append(_AnsweredCall(function, arguments, reply))
        if case is not None:
            self._recorder.case = ReplayCase(case.function, case.arguments, case.kit, reply)

    def stdout(self) -> str:
        return self._program.stdout()

    def close(self) -> None:
        self._program.close()


def _json_sort_key(value: Any) -> str:
    return json.dumps(value, sort_keys=True)
