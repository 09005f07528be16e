"""The runner: keeps a program alive over the checks of one grading, and what was seen of it."""

from __future__ import annotations

import itertools
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from graders.core.code.batch_judging import concatenate_blocks
from graders.core.code.piggyback import PiggybackCalls
from graders.core.code.pipelining import CallPipeline, fatal_fault
from graders.core.compare.shrinking import Budget
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import (
    Answer,
    KitSettings,
    PlannedCalls,
    PreparablePrograms,
    Program,
    Programs,
    Reply,
    StudentFault,
)
from graders.core.contract.values import Arguments, Value

#: How often the main program may be started anew, and how many others, one for each map or each run of a closed loop.
MAX_LAUNCHES = 12
MAX_SIDE_PROGRAMS = 64
DEFAULT_BUDGET = Budget()


@dataclass(slots=True)
class Observation:
    """What a function gave on one graded input (a value, or the name of the fault), and whether that was right."""

    check: str
    index: int
    function: str
    value: Value
    fault: str | None
    ok: bool


class Runner:
    """Keeps a program alive over the checks of one grading; a program that died is started anew.

    A function that exhausted a limit or killed its process is not called again. `reenacting` says that only the
    observations are wanted: no counterexample is shrunk. `budget` is for each of those that are. `failed` are the ids
    of the checks that have failed so far, for those that depend on them.
    """

    def __init__(
        self,
        programs: Programs,
        source: bytes,
        kit: KitSettings,
        *,
        reenacting: bool = False,
        budget: Budget = DEFAULT_BUDGET,
    ) -> None:
        self.reenacting = reenacting
        self.budget = budget
        self._begun, self._told = time.perf_counter(), 0
        self._programs = programs
        self._source = source
        self._kit = kit
        self._launches = 0
        self._others = self._expected = 0
        self._program: Program | None = None
        self._dead: dict[str, StudentFault] = {}
        self._ahead = CallPipeline()
        self._beside = PiggybackCalls()
        self._seen: list[Observation] = []
        self._unwritten: list[Callable[[], Iterable[Observation]]] = []
        self.films: dict[str, FigureData] = {}
        self.failed: set[str] = set()
        self.stdout = ""

    @property
    def observations(self) -> list[Observation]:
        """What was observed so far, in its order."""
        unwritten, self._unwritten = self._unwritten, []
        for written in unwritten:
            self._seen += written()
        return self._seen

    def observe(self, written: Callable[[], Iterable[Observation]]) -> None:
        """Observations that are written down once somebody reads them: of a right program nobody does."""
        self._unwritten.append(written)

    @property
    def program(self) -> Program:
        """The program on the main map. Raises StudentFault when its file does not load."""
        return self._program or self._launched()

    def _launched(self, ahead: Sequence[PlannedCalls] = ()) -> Program:
        self._launches += 1
        self._program = self._start(self._kit, self._launches, MAX_LAUNCHES, ahead)
        return self._program

    def _start(self, kit: KitSettings, launches: int, most: int, ahead: Sequence[PlannedCalls] = ()) -> Program:
        if launches > most:
            raise StudentFault(Outcome.RUNTIME_ERROR, "Votre programme s'est arrêté trop souvent.", fatal=True)
        return self._programs.open(self._source, kit, ahead)

    @property
    def seconds_per_call(self) -> float:
        """Seconds that a call has taken so far, with all that was done of its answer."""
        return (time.perf_counter() - self._begun) / max(1, self._told)

    def answer_batches(self, asked: Sequence[PlannedCalls]) -> Sequence[Sequence[Answer]]:
        """The answers of the main program to all of these calls, which are asked together, as far as there are any.

        A function that is not called again gives none. What is to be asked beside goes with them, after them.
        """
        beside = self._beside.take_queued(self.seconds_per_call)
        self.plan([*asked, *beside])
        told = [list(self.answers(one)) if self.is_callable(one.function) else [] for one in asked]
        self._take_beside(beside)
        return told

    def piggyback(self, asked: Sequence[PlannedCalls]) -> None:
        """Has these asked with the next exchange, whenever that is: see `Beside`."""
        self._beside.queue(asked)

    def piggybacked_answers(self, asked: PlannedCalls) -> Sequence[Answer] | None:
        """The answers to what was to be asked beside others; None where it must be asked of a program of its own.

        It is the last thing that the main program is asked, at the latest: what it prints meanwhile is not shown.
        """
        beside = [one for one in self._beside.take_queued(self.seconds_per_call) if self.is_callable(one.function)]
        if beside and self._program is not None:
            self.freeze_stdout()
            printed = self.stdout
            self.plan(beside)
            self._asked_with_the_rest(beside[0])
            self._take_beside(beside)
            self.close()
            self.stdout = printed
        return self._beside.answers(asked)

    def _take_beside(self, asked: Sequence[PlannedCalls]) -> None:
        """No fault here costs a function anything."""
        if asked:
            self._beside.store_answers(
                {one: concatenate_blocks(self._unmourned(one)) for one in asked if self.is_callable(one.function)}
            )

    def _unmourned(self, asked: PlannedCalls) -> Iterator[Sequence[Answer]]:
        ready = self._ahead.ready_blocks(asked)
        while ready or self._ahead.is_pending(asked):
            if ready:
                yield ready.popleft()
            else:
                self._take_in()

    def plan(self, plan: Sequence[PlannedCalls]) -> None:
        """What the next checks will ask of the main program, in this order and nothing else in between."""
        self._settle()
        self._ahead.set_plan(plan)

    def start(self, plan: Sequence[PlannedCalls]) -> None:
        """Start the main program, with what is asked of it first. Raises StudentFault when its file does not load."""
        self._ahead.set_plan(plan)
        self._ahead.send(self._launched(plan), plan)

    def answers(self, asked: PlannedCalls) -> Iterator[Answer]:
        """The answers of the main program to what may have been foreseen, as the calls made now would give them."""
        return itertools.chain.from_iterable(self.answer_blocks(asked))

    def answer_blocks(self, asked: PlannedCalls) -> Iterator[Sequence[Answer]]:
        """As `answers`, with those together that have come together; a fatal one is alone.

        Nothing is waited for beyond the answer to the last of the calls.
        """
        if self._refused(asked.function) or not self._ahead.is_planned(asked):
            yield from self._asked_now(asked)
            return
        try:
            ready = self._ahead.ready_blocks(asked)
            ready = self._asked_with_the_rest(asked) if ready is None else ready
        except StudentFault as fault:
            self._mourn(None, asked.function, fault)
            yield (fault,)
            return
        left = len(asked.calls)
        while left and (ready or self._ahead.is_pending(asked)):
            if not ready:
                self._take_in()
                continue
            answers = ready.popleft()
            if last := fatal_fault(answers):
                self._dead[asked.function] = last
            self._told += len(answers)
            left -= len(answers)
            yield answers

    def _asked_now(self, asked: PlannedCalls) -> Iterator[Sequence[Answer]]:
        if not asked.return_arguments:
            yield from self._asked_alone(asked)
            return
        for args in asked.calls:
            try:
                yield (self.call(None, asked.function, args, keep=True),)
            except StudentFault as fault:
                yield (fault,)

    def _asked_alone(self, asked: PlannedCalls) -> Iterator[Sequence[Answer]]:
        refused = self._refused(asked.function)
        if refused is not None:
            yield (refused,)
            return
        self._settle()
        try:
            given = self.program.call_batches([asked])
        except StudentFault as fault:
            given = iter([(0, (fault,))])
        for _, answers in given:
            self._told += len(answers)
            if last := fatal_fault(answers):
                self._mourn(None, asked.function, last)
            yield answers

    def _asked_with_the_rest(self, asked: PlannedCalls) -> deque[Sequence[Answer]]:
        self._settle()
        together = self._ahead.batches_from(asked, self._dead)
        self._ahead.send(self._program or self._launched(together), together)
        ready = self._ahead.ready_blocks(asked)
        assert ready is not None, "it was asked"
        return ready

    def _settle(self) -> None:
        """Have all answers in that are on their way: nothing else can be asked before."""
        while self._ahead.has_pending:
            self._take_in()

    def _take_in(self) -> None:
        if self._ahead.receive_block():
            self.close()

    def call(self, program: Program | None, function: str, args: Arguments, *, keep: bool) -> Reply:
        """Call a function of a program (None: of the main one)."""
        refused = self._refused(function)
        if refused is not None:
            raise refused
        if program is None:
            self._settle()
        self._told += 1
        try:
            return (program or self.program).call(function, *args, return_arguments=keep)
        except StudentFault as fault:
            self._mourn(program, function, fault)
            raise

    def call_many(
        self, program: Program | None, function: str, calls: Iterable[Arguments], *, faults: int | None
    ) -> Iterator[Answer]:
        """As `Program.call_many`, of a program (None: of the main one)."""
        refused = self._refused(function)
        if refused is not None:
            return iter((refused,))
        return self.watch_answers(program, function, self._answers(program, function, calls, faults))

    def watch_answers(self, program: Program | None, function: str, answers: Iterator[Answer]) -> Iterator[Answer]:
        """The same answers; what they say of the program's end is noted."""
        for answer in answers:
            self.note(program, function, answer)
            yield answer

    def note(self, program: Program | None, function: str, answer: Answer) -> None:
        """What an answer of a program says of its end."""
        self._told += 1
        if isinstance(answer, StudentFault):
            self._mourn(program, function, answer)

    def is_callable(self, function: str) -> bool:
        """Whether a function is still called."""
        return function not in self._dead

    def _answers(
        self, program: Program | None, function: str, calls: Iterable[Arguments], faults: int | None
    ) -> Iterator[Answer]:
        if program is None:
            self._settle()
        try:
            return (program or self.program).call_many(function, calls, faults=faults)
        except StudentFault as fault:
            return iter((fault,))

    def _refused(self, function: str) -> StudentFault | None:
        """The fault that answers for a function that is not called again."""
        before = self._dead.get(function)
        if before is None:
            return None
        return StudentFault(before.outcome, f"{function} n'est pas rappelée : {before.message}", fatal=True)

    def _mourn(self, program: Program | None, function: str, fault: StudentFault) -> None:
        if fault.fatal:
            self._dead[function] = fault
            self._drop(program)

    def _drop(self, program: Program | None) -> None:
        if self._program is not None and program in (None, self._program):
            self.close()

    def announce_launches(self, launches: int) -> None:
        """The file is about to be started so many times more."""
        self._expected += launches
        if self._expected and isinstance(self._programs, PreparablePrograms):
            self._programs.prepare(self._source, self._kit, self._expected)

    @contextmanager
    def side_program(self, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Iterator[Program]:
        """The same file started on another map, for as long as the block lasts; what is asked `ahead` goes with it."""
        self._others += 1
        self._expected = max(0, self._expected - 1)
        program = self._start(kit, self._others, MAX_SIDE_PROGRAMS, ahead)
        try:
            yield program
        finally:
            program.close()

    def freeze_stdout(self) -> None:
        """What is printed from here on is not shown, unless nothing was before."""
        self._settle()
        if self._program is not None:
            self.stdout = self.stdout or self._program.stdout()

    def close(self) -> None:
        """Keep what was printed and give the main program back."""
        if self._program is not None:
            self._ahead.discard_pending()
            self.stdout = self.stdout or self._program.stdout()
            self._program.close()
            self._program = None
