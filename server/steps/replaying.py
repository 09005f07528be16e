"""The call that a failed check shows, found again: the check is run once more, and what it asks is noted.

A check draws its inputs from the seed of its grading: run again on the same program, it comes to the same case. What a
verdict holds of that case is for people to read; the call is made of the very values.
"""

from __future__ import annotations

import copy
import json
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection
from graders.core.code.exercise import CodeDefinition
from graders.core.code.runner import Runner
from graders.core.code.simplifying import run_alone
from graders.core.compare.words import to_jsonable
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, Block, Foreseen, KitSettings, Program, Programs, Reply, StudentFault
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments, Value

#: Seconds that looking for the call may take.
LONGEST = 8.0
#: Calls of which the answers are remembered.
REMEMBERED = 500
_NOT_ASKED = "La recherche de ce cas a pris trop de temps."


@dataclass(frozen=True)
class Case:
    """A call, the kit under which it was made, and what came back of it; None for a fault."""

    function: str
    arguments: Arguments
    kit: KitSettings
    reply: Reply | None


def find(
    definition: CodeDefinition,
    check_id: str,
    inputs: Mapping[str, Any],
    source: bytes,
    programs: Programs,
    *,
    seed: int,
) -> Case | None:
    """The call whose arguments a verdict shows as `inputs`; None where the check does not come to it any more."""
    check = next((one for one in definition.checks if one.id == check_id), None)
    if check is None:
        return None
    kit = definition.kit(stream(seed, "kit"))
    noted = _Noted(programs, inputs)
    runner = Runner(noted, source, kit)
    try:
        _run(check, Bench(check.id, runner, stream(seed, check.id), kit), noted)
    except StudentFault:
        pass
    finally:
        runner.close()
    return noted.case


def _run(check: Check, bench: Bench, noted: _Noted) -> None:
    try:
        run_alone(check.run, bench)
    except Rejection as rejection:
        if rejection.call is not None and _same(rejection.inputs or {}, noted.inputs):
            noted.settle(*rejection.call)


def _same(inputs: Mapping[str, Value], told: Mapping[str, Any]) -> bool:
    return {name: to_jsonable(value) for name, value in inputs.items()} == told


@dataclass(frozen=True)
class _Answered:
    function: str
    arguments: Arguments
    reply: Reply | None

    def is_of(self, function: str, arguments: Arguments) -> bool:
        """Whether it is the call of these very objects."""
        pairs = zip(self.arguments, arguments, strict=False)
        return (self.function, len(self.arguments)) == (function, len(arguments)) and all(a is b for a, b in pairs)


class _Noted:
    """Programs of which each call is compared with what a verdict shows; the last that is the same is `case`."""

    def __init__(self, programs: Programs, inputs: Mapping[str, Any]) -> None:
        self.inputs = dict(inputs)
        self.case: Case | None = None
        self._programs = programs
        self._sought = sorted(map(_key, inputs.values()))
        self._until = time.monotonic() + LONGEST
        self._kit: KitSettings | None = None
        self.last: deque[_Answered] = deque(maxlen=REMEMBERED)

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[Foreseen] = ()) -> Program:
        self.must_last()
        return _NotedProgram(self._programs.open(source, kit, ahead), kit, self)

    def must_last(self) -> None:
        """Raises StudentFault, which ends the check, once it takes too long."""
        if time.monotonic() > self._until:
            raise StudentFault(Outcome.TIMEOUT, _NOT_ASKED, fatal=True)

    def note(self, function: str, arguments: Arguments, kit: KitSettings) -> Case | None:
        """The call as a case, where it is the one that is sought; arguments are kept as they were before it."""
        self._kit = kit
        if len(arguments) != len(self._sought) or sorted(_key(to_jsonable(one)) for one in arguments) != self._sought:
            return None
        return Case(function, copy.deepcopy(arguments), kit, None)

    def settle(self, function: str, arguments: Arguments) -> None:
        """The check itself has told the call."""
        assert self._kit is not None, "what is rejected was called"
        answers = (call.reply for call in reversed(self.last) if call.is_of(function, arguments))
        self.case = Case(function, arguments, self._kit, next(answers, None))


class _NotedProgram:
    def __init__(self, program: Program, kit: KitSettings, noted: _Noted) -> None:
        self._program, self._kit, self._noted = program, kit, noted

    @property
    def functions(self) -> frozenset[str]:
        return self._program.functions

    def call(self, function: str, *args: Value, return_arguments: bool = False) -> Reply:
        self._noted.must_last()
        case = self._noted.note(function, args, self._kit)
        self._noted.case = case or self._noted.case
        reply = self._program.call(function, *args, return_arguments=return_arguments)
        self._noted.last.append(_Answered(function, args, reply))
        if case is not None:
            self._noted.case = Case(case.function, case.arguments, case.kit, reply)
        return reply

    def call_many(self, function: str, calls: Iterable[Arguments], *, faults: int | None = None) -> Iterator[Answer]:
        asked: deque[tuple[Arguments, Case | None]] = deque()

        def noted() -> Iterator[Arguments]:
            for arguments in calls:
                asked.append((arguments, self._noted.note(function, arguments, self._kit)))
                yield arguments

        for answer in self._program.call_many(function, noted(), faults=faults):
            self._answered(function, asked, answer)
            yield answer

    def together(self, asked: Sequence[Foreseen]) -> Iterator[Block]:
        noted = [deque((args, self._noted.note(one.function, args, self._kit)) for args in one.calls) for one in asked]
        for number, answers in self._program.together(asked):
            for answer in answers:
                self._answered(asked[number].function, noted[number], answer)
            yield number, answers

    def _answered(self, function: str, asked: deque[tuple[Arguments, Case | None]], answer: Answer) -> None:
        """The answer to the first of these."""
        self._noted.must_last()
        if not asked:
            return
        arguments, case = asked.popleft()
        reply = answer if isinstance(answer, Reply) else None
        self._noted.last.append(_Answered(function, arguments, reply))
        if case is not None:
            self._noted.case = Case(case.function, case.arguments, case.kit, reply)

    def stdout(self) -> str:
        return self._program.stdout()

    def close(self) -> None:
        self._program.close()


def _key(value: Any) -> str:
    return json.dumps(value, sort_keys=True)
