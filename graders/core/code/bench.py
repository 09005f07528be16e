"""The bench: one check's access to the student's functions, and the record of its observations.

A diagnosis compares observations: the same check run on a known mistake makes the same list of observations, so that
two programs are compared by their outputs alone.
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
    """One check's access to the program: `rng` draws inputs, `call` calls functions, `observe` records results."""

    check: str
    runner: Runner
    rng: np.random.Generator
    kit: KitSettings
    program: Program | None = None
    #: The settings of the side program on which the check runs, or failed; None for the main one.
    side_kit: KitSettings | None = None
    last_call: tuple[str, Arguments] | None = None
    #: The calls that the check announced before it ran.
    planned_calls: Sequence[PlannedCalls] = ()
    #: What the check measured of a right program, in a sentence for its author; "" where points say it all.
    measured: str = ""
    _count: list[int] = field(default_factory=lambda: [0])
    _prefetched: dict[Key, deque[Answer]] = field(default_factory=dict)
    _unindexed: list[tuple[PlannedCalls, Sequence[Answer]]] = field(default_factory=list)
    _first_answers: Iterator[tuple[int, Answer]] | None = None
    _planned_turns: Iterator[Turn] | None = None
    _next_planned: Turn | None = None

    def call(self, function: str, *args: Value) -> Value:
        """Call a function by position and return its value as plain data. Raises StudentFault."""
        self.last_call = (function, args)
        answer = self._prefetched_answer(function, args)
        if answer is None:
            return self.runner.call(self.program, function, args, keep=False).value
        if isinstance(answer, StudentFault):
            raise answer
        return answer.value

    def _prefetched_answer(self, function: str, args: Arguments) -> Answer | None:
        """Return the prefetched answer to a call: from `prefetch`, or the next planned call; None otherwise."""
        for batch, answers_received in self._unindexed:
            for arguments, answer in zip(batch.calls, answers_received, strict=False):
                self._prefetched.setdefault(_hashable_call_key(batch.function, arguments), deque()).append(answer)
        self._unindexed.clear()
        stored = self._prefetched.get(_hashable_call_key(function, args)) if self._prefetched else None
        if stored:
            return stored.popleft()
        if self._planned_turns is None:
            self._planned_turns = self._iter_planned() if self.program is None else iter(())
            self._next_planned = next(self._planned_turns, None)
        if self._next_planned is None:
            return None
        next_function, planned_args, answers = self._next_planned
        if function != next_function or len(args) != len(planned_args) or any(map(is_not, args, planned_args)):
            return None
        self._next_planned = next(self._planned_turns, None)
        return next(answers, None)

    def _iter_planned(self) -> Iterator[Turn]:
        """Yield the planned calls in order: function, arguments, iterator of answers."""
        for batch in self.planned_calls:
            answers = self.runner.iter_answers(batch)
            yield from ((batch.function, args, answers) for args in batch.calls)

    def prefetch(self, batch: PlannedCalls) -> Sequence[Answer]:
        """Make calls in one exchange; later uses of `call` with the same arguments get their answers.

        Empty for a re-enacted mistake, which runs in this process and makes each call when needed.
        """
        if self.runner.reenacting:
            return []
        answers = concatenate_blocks(self.answer_blocks(batch))
        self._unindexed.append((batch, answers))
        return answers

    def answer_blocks(self, batch: PlannedCalls) -> Iterator[Sequence[Answer]]:
        """Yield the answers in blocks, as they arrive."""
        if self.program is None:
            return self.runner.answer_blocks(batch)
        return ((answer,) for _, answer in self.iter_answers(batch))

    def iter_answers(self, batch: PlannedCalls) -> Iterator[tuple[Arguments, Answer]]:
        """Yield the arguments and the answer of each call, planned or not."""
        if self.program is None:
            answers = self.runner.iter_answers(batch)
        elif self._first_answers is not None and any(batch is planned for planned in self.planned_calls):
            answers = self.runner.watch_answers(
                self.program, batch.function, (answer for _, answer in self._first_answers)
            )
        else:
            answers = self.runner.call_many(self.program, batch.function, batch.calls, faults=batch.faults)
        for args, answer in zip(batch.calls, answers, strict=False):
            self.last_call = (batch.function, args)
            yield args, answer

    def call_many(
        self, function: str, calls: Iterable[Arguments], *, faults: int | None = None
    ) -> Iterator[tuple[Arguments, Answer]]:
        """Yield the arguments and the answer of each call in order, pipelined: see `Program.call_many`."""
        ahead, repeated_calls = itertools.tee(calls)
        answers = self.runner.call_many(self.program, function, ahead, faults=faults)
        for answer, args in zip(answers, repeated_calls, strict=False):
            self.last_call = (function, args)
            yield args, answer

    def answer_batches(self, batches: Sequence[PlannedCalls]) -> Sequence[Sequence[Answer]]:
        """Return the answers to several batches, made in one exchange on the main program; [] where there are none."""
        if self.program is None:
            return self.runner.answer_batches(batches)
        return [
            list(self.runner.call_many(self.program, batch.function, batch.calls, faults=None))
            if self.runner.is_callable(batch.function)
            else []
            for batch in batches
        ]

    def observe(self, function: str, value: Value, *, ok: bool, fault: StudentFault | None = None) -> None:
        """Record the result of a function; a fault by the name of its exception or outcome."""
        name = (fault.exception or fault.outcome.value) if fault else None
        observation = Observation(self.check, self._count[0], function, compact_value(value), name, ok)
        self.runner.observe(lambda: (observation,))
        self._count[0] += 1

    def observe_all(self, function: str, values: Floats, right: Sequence[bool | None]) -> None:
        """Record many results of a function: small values (n, …)."""
        check, first_index = self.check, self._count[0]
        self._count[0] += len(values)

        def make_observations() -> Iterator[Observation]:
            for index, (value, ok) in enumerate(zip(split_rows(values), right, strict=True), first_index):
                yield Observation(check, index, function, value, None, bool(ok))

        self.runner.observe(make_observations)

    def record_film(self, data: FigureData) -> None:
        """Keep a film of the program's run in this check, passed or failed, for its author to watch.

        `data` are plain values and arrays, of few digits (some 60 KB as JSON; all the films of a grading share
        `contract.films.FILM_BYTES`); numbers that are not finite become None. Its "kind" names the function of the
        exercise's `replays.py` that makes the replay. One film a check: the last one (of several runs, pass a failed
        one).
        """
        if not self.runner.reenacting:
            self.runner.films[self.check] = data

    @contextmanager
    def run_with_kit(self, kit: KitSettings, first: PlannedCalls | None = None) -> Iterator[Bench]:
        """Yield the same bench with the program started on another map; the batch `first` travels with its file."""
        ahead = [first] if first is not None and self.runner.is_callable(first.function) else []
        self.side_kit = kit
        with self.runner.side_program(kit, ahead) as program:
            bench = Bench(self.check, self.runner, self.rng, kit, program, _count=self._count)
            if ahead:
                bench.planned_calls, bench._first_answers = ahead, flatten_blocks(program.call_batches(ahead))
            yield bench
        self.side_kit = None  # what fails later fails on the main program


def _hashable_call_key(function: str, args: Arguments) -> Key:
    """Return a hashable key of a call: numbers and arrays by their bytes."""
    arrays = [np.asarray(arg) for arg in args]
    return function, tuple((array.dtype.str, array.shape, array.tobytes()) for array in arrays)
