"""The bench: where one check calls the student's functions, and where what it saw is written down.

Observations are what a diagnosis works on: the same check run on a known mistake makes the same list of observations,
so that two programs can be compared by their outputs alone.
"""

from __future__ import annotations

import itertools
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from operator import is_not

import numpy as np

from graders.core.code.batch_judging import concatenate_blocks
from graders.core.code.runner import Observation, Runner
from graders.core.contract.findings import FigureData
from graders.core.contract.program import Answer, KitSettings, PlannedCalls, Program, StudentFault, flatten_blocks
from graders.core.contract.rows import split_rows
from graders.core.contract.values import Arguments, Floats, Value, compact_value

Turn = tuple[str, Arguments, Iterator[Answer]]
Key = tuple[str, tuple[tuple[str, tuple[int, ...], bytes], ...]]


@dataclass
class Bench:
    """One check's access to the program: `rng` draws its inputs, `call` asks, `observe` writes down."""

    check: str
    runner: Runner
    rng: np.random.Generator
    kit: KitSettings
    program: Program | None = None
    last_call: tuple[str, Arguments] | None = None
    #: What the check was seen to ask, before it began.
    planned_calls: Sequence[PlannedCalls] = ()
    _count: list[int] = field(default_factory=lambda: [0])
    _known: dict[Key, deque[Answer]] = field(default_factory=dict)
    _taken: list[tuple[PlannedCalls, Sequence[Answer]]] = field(default_factory=list)
    _first: Iterator[tuple[int, Answer]] | None = None
    _turn: Iterator[Turn] | None = None
    _next: Turn | None = None

    def call(self, function: str, *args: Value) -> Value:
        """Call a function by position and return its value as plain data. Raises StudentFault."""
        self.last_call = (function, args)
        answer = self._asked_before(function, args)
        if answer is None:
            return self.runner.call(self.program, function, args, keep=False).value
        if isinstance(answer, StudentFault):
            raise answer
        return answer.value

    def _asked_before(self, function: str, args: Arguments) -> Answer | None:
        """The answer to a call that was made ahead: one that `ahead` has taken, or the next that was foreseen."""
        for taken, came in self._taken:
            for given, answer in zip(taken.calls, came, strict=False):
                self._known.setdefault(_key(taken.function, given), deque()).append(answer)
        self._taken.clear()
        known = self._known.get(_key(function, args)) if self._known else None
        if known:
            return known.popleft()
        if self._turn is None:
            self._turn = self._turns() if self.program is None else iter(())
            self._next = next(self._turn, None)
        if self._next is None:
            return None
        asked, foreseen, answers = self._next
        if function != asked or len(args) != len(foreseen) or any(map(is_not, args, foreseen)):
            return None
        self._next = next(self._turn, None)
        return next(answers, None)

    def _turns(self) -> Iterator[Turn]:
        """The calls foreseen, in order: function, arguments, and where their answers come from."""
        for asked in self.planned_calls:
            answers = self.runner.answers(asked)
            yield from ((asked.function, args, answers) for args in asked.calls)

    def prefetch(self, asked: PlannedCalls) -> Sequence[Answer]:
        """The answers of calls made together before a protocol comes to them, which it then finds with `call`.

        A re-enacted mistake has no time to win: it makes each call in its turn.
        """
        if self.runner.reenacting:
            return []
        answers = concatenate_blocks(self.answer_blocks(asked))
        self._taken.append((asked, answers))
        return answers

    def answer_blocks(self, asked: PlannedCalls) -> Iterator[Sequence[Answer]]:
        """The answers alone, with those together that have come together."""
        if self.program is None:
            return self.runner.answer_blocks(asked)
        return ((answer,) for _, answer in self.answers(asked))

    def answers(self, asked: PlannedCalls) -> Iterator[tuple[Arguments, Answer]]:
        """The arguments and the answer of each call, whether it was foreseen or is made now."""
        if self.program is None:
            answers = self.runner.answers(asked)
        elif self._first is not None and any(asked is one for one in self.planned_calls):
            answers = self.runner.watch_answers(self.program, asked.function, (answer for _, answer in self._first))
        else:
            answers = self.runner.call_many(self.program, asked.function, asked.calls, faults=asked.faults)
        for args, answer in zip(asked.calls, answers, strict=False):
            self.last_call = (asked.function, args)
            yield args, answer

    def call_many(
        self, function: str, calls: Iterable[Arguments], *, faults: int | None = None
    ) -> Iterator[tuple[Arguments, Answer]]:
        """The arguments and the answer of each call, in order: calls are made ahead, see `Program.call_many`."""
        ahead, asked = itertools.tee(calls)
        answers = self.runner.call_many(self.program, function, ahead, faults=faults)
        for answer, args in zip(answers, asked, strict=False):
            self.last_call = (function, args)
            yield args, answer

    def answer_batches(self, asked: Sequence[PlannedCalls]) -> Sequence[Sequence[Answer]]:
        """The answers to all of these calls, as far as there are any: in one exchange on the main program."""
        if self.program is None:
            return self.runner.answer_batches(asked)
        return [
            list(self.runner.call_many(self.program, one.function, one.calls, faults=None))
            if self.runner.is_callable(one.function)
            else []
            for one in asked
        ]

    def observe(self, function: str, value: Value, *, ok: bool, fault: StudentFault | None = None) -> None:
        """Write down what a function gave; a fault is known by its exception's or its outcome's name."""
        name = (fault.exception or fault.outcome.value) if fault else None
        observation = Observation(self.check, self._count[0], function, compact_value(value), name, ok)
        self.runner.observe(lambda: (observation,))
        self._count[0] += 1

    def observe_all(self, function: str, values: Floats, right: Sequence[bool | None]) -> None:
        """As `observe`, of values that are small (n, …)."""
        check, begins = self.check, self._count[0]
        self._count[0] += len(values)

        def written() -> Iterator[Observation]:
            for index, (value, ok) in enumerate(zip(split_rows(values), right, strict=True), begins):
                yield Observation(check, index, function, value, None, bool(ok))

        self.runner.observe(written)

    def film(self, data: FigureData) -> None:
        """Keep what the program did in this check, whether it passes or fails, so that its author can watch it.

        `data` are plain values and arrays, of few digits (some 60 KB as JSON; all the films of a grading share
        `contract.films.FILM_BYTES`); what is not finite becomes None. Its "kind" names the function of the exercise's
        `replays.py` that makes a replay of it, when somebody looks. One film a check: the last one kept (of several
        runs, keep one that failed).
        """
        if not self.runner.reenacting:
            self.runner.films[self.check] = data

    @contextmanager
    def on(self, kit: KitSettings, first: PlannedCalls | None = None) -> Iterator[Bench]:
        """The same bench with the program started on another map, and asked there something `first`."""
        ahead = [first] if first is not None and self.runner.is_callable(first.function) else []
        with self.runner.side_program(kit, ahead) as program:
            bench = Bench(self.check, self.runner, self.rng, kit, program, _count=self._count)
            if ahead:
                bench.planned_calls, bench._first = ahead, flatten_blocks(program.call_batches(ahead))
            yield bench


def _key(function: str, args: Arguments) -> Key:
    """The same for the same call: numbers and arrays are known by their bytes."""
    arrays = [np.asarray(arg) for arg in args]
    return function, tuple((array.dtype.str, array.shape, array.tobytes()) for array in arrays)
