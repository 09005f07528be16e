"""The runner: keeps a student's program alive over the checks of one grading, and collects the observations."""

from __future__ import annotations

import itertools
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
    clock_of_programs,
)
from graders.core.contract.values import Arguments, Value

#: Launches of the main program; launches of side programs, one for each other map or run of a closed loop.
MAX_LAUNCHES = 12
MAX_SIDE_PROGRAMS = 64
DEFAULT_BUDGET = Budget()


@dataclass(slots=True)
class Observation:
    """The result of a function on one graded input (a value, or the name of the fault), and whether it is right."""

    check: str
    index: int
    function: str
    value: Value
    fault: str | None
    ok: bool


class Runner:
    """Keeps a program alive over the checks of one grading, and restarts one that died.

    A function that exhausted a limit or killed its process is not called again. With `reenacting`, only observations
    are needed, and no counterexample is shrunk. `budget` bounds the shrinking of each counterexample. `failed` are the
    ids of the checks that have failed so far.
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
        self.reenacting, self.budget = reenacting, budget
        self.clock = clock_of_programs(programs)
        self._started_at, self._answer_count = self.clock(), 0
        self.programs = programs
        self._source = source
        self._kit, self._launches = kit, 0
        self._side_programs = self._announced = 0
        self._program: Program | None = None
        self._dead_functions: dict[str, StudentFault] = {}
        self._pipeline = CallPipeline()
        self._piggybacked = PiggybackCalls(self.clock)
        self._observations: list[Observation] = []
        self._deferred: list[Callable[[], Iterable[Observation]]] = []
        self.films: dict[str, FigureData] = {}
        self.failed: set[str] = set()
        self.stale: frozenset[str] = frozenset()  # functions that give old answers to new calls
        self.stdout = ""

    @property
    def source(self) -> bytes:
        return self._source

    @property
    def observations(self) -> list[Observation]:
        """All observations so far, in order."""
        deferred, self._deferred = self._deferred, []
        for make_observations in deferred:
            self._observations += make_observations()
        return self._observations

    def observe(self, make_observations: Callable[[], Iterable[Observation]]) -> None:
        """Add observations that are made when they are first read: those of a right program never are."""
        self._deferred.append(make_observations)

    @property
    def program(self) -> Program:
        """The program on the main map. Raises StudentFault when its file does not load."""
        return self._program or self._launch_main()

    def _launch_main(self, ahead: Sequence[PlannedCalls] = ()) -> Program:
        self._launches += 1
        self._program = self._start_within_limit(self._kit, self._launches, MAX_LAUNCHES, ahead)
        return self._program

    def _start_within_limit(
        self, kit: KitSettings, launches: int, max_launches: int, ahead: Sequence[PlannedCalls] = ()
    ) -> Program:
        if launches > max_launches:
            raise StudentFault(Outcome.RUNTIME_ERROR, "Votre programme s'est arrêté trop souvent.", fatal=True)
        return self.programs.open(self._source, kit, ahead)

    @property
    def seconds_per_call(self) -> float:
        """Mean seconds of a call so far, with the handling of its answer."""
        return (self.clock() - self._started_at) / max(1, self._answer_count)

    def answer_batches(self, batches: Sequence[PlannedCalls]) -> Sequence[Sequence[Answer]]:
        """Return the answers of the main program to several batches, sent in one exchange.

        [] for a function that is no longer called. Queued piggyback calls follow in the same exchange.
        """
        queued = self._piggybacked.take_queued(self.seconds_per_call)
        self.set_plan([*batches, *queued])
        answers = [list(self.iter_answers(batch)) if self.is_callable(batch.function) else [] for batch in batches]
        self._store_piggybacked(queued)
        return answers

    def queue_piggyback_calls(self, batches: Sequence[PlannedCalls]) -> None:
        """Queue these batches for the next exchange: see `PiggybackCalls`."""
        self._piggybacked.queue(batches)

    def piggybacked_answers(self, batch: PlannedCalls) -> Sequence[Answer] | None:
        """Return the answers to a piggyback batch; None where a fresh launch must be asked.

        Batches that are still queued are sent now, as the last calls of the main program; their prints are not shown.
        """
        queued = [
            queued_batch
            for queued_batch in self._piggybacked.take_queued(self.seconds_per_call)
            if self.is_callable(queued_batch.function)
        ]
        if queued and self._program is not None:
            self.freeze_stdout()
            printed = self.stdout
            self.set_plan(queued)
            self._send_remaining_plan(queued[0])
            self._store_piggybacked(queued)
            self.close()
            self.stdout = printed
        return self._piggybacked.stored_answers(batch)

    def _store_piggybacked(self, batches: Sequence[PlannedCalls]) -> None:
        """Store the answers to piggyback batches; their faults do not count against a function."""
        if batches:
            self._piggybacked.store_answers(
                {
                    batch: concatenate_blocks(self._iter_planned_blocks(batch))
                    for batch in batches
                    if self.is_callable(batch.function)
                }
            )

    def _iter_planned_blocks(self, batch: PlannedCalls) -> Iterator[Sequence[Answer]]:
        ready = self._pipeline.ready_blocks(batch)
        while ready or self._pipeline.is_pending(batch):
            if ready:
                yield ready.popleft()
            else:
                self._receive_next_block()

    def set_plan(self, plan: Sequence[PlannedCalls]) -> None:
        """Set the next calls of the main program, in this order and without others in between."""
        self._receive_pending()
        self._pipeline.set_plan(plan)

    def start(self, plan: Sequence[PlannedCalls]) -> None:
        """Start the main program together with its first calls. Raises StudentFault when its file does not load."""
        self._pipeline.set_plan(plan)
        self._pipeline.send(self._launch_main(plan), plan)

    def iter_answers(self, batch: PlannedCalls) -> Iterator[Answer]:
        """Yield the answers of the main program to a batch, planned or not."""
        return itertools.chain.from_iterable(self.answer_blocks(batch))

    def answer_blocks(self, batch: PlannedCalls) -> Iterator[Sequence[Answer]]:
        """Yield the answers in blocks as they arrive; a fatal fault is alone. Return after the last call's answer."""
        if self._refusal_of_dead_function(batch.function) or not self._pipeline.is_planned(batch):
            yield from self._call_now(batch)
            return
        try:
            ready = self._pipeline.ready_blocks(batch)
            ready = self._send_remaining_plan(batch) if ready is None else ready
        except StudentFault as fault:
            self._record_fault(None, batch.function, fault)
            yield (fault,)
            return
        left = len(batch.calls)
        while left and (ready or self._pipeline.is_pending(batch)):
            if not ready:
                self._receive_next_block()
                continue
            answers = ready.popleft()
            if last := fatal_fault(answers):
                self._dead_functions[batch.function] = last
            self._answer_count += len(answers)
            left -= len(answers)
            yield answers

    def _call_now(self, batch: PlannedCalls) -> Iterator[Sequence[Answer]]:
        if not batch.return_arguments:
            yield from self._call_unplanned(batch)
            return
        for args in batch.calls:
            try:
                yield (self.call(None, batch.function, args, keep=True),)
            except StudentFault as fault:
                yield (fault,)

    def _call_unplanned(self, batch: PlannedCalls) -> Iterator[Sequence[Answer]]:
        refusal = self._refusal_of_dead_function(batch.function)
        if refusal is not None:
            yield (refusal,)
            return
        self._receive_pending()
        try:
            blocks = self.program.call_batches([batch])
        except StudentFault as fault:
            blocks = iter([(0, (fault,))])
        for _, answers in blocks:
            self._answer_count += len(answers)
            if last := fatal_fault(answers):
                self._record_fault(None, batch.function, last)
            yield answers

    def _send_remaining_plan(self, batch: PlannedCalls) -> deque[Sequence[Answer]]:
        self._receive_pending()
        batches = self._pipeline.batches_from(batch, self._dead_functions)
        self._pipeline.send(self._program or self._launch_main(batches), batches)
        ready = self._pipeline.ready_blocks(batch)
        assert ready is not None, "it was asked"
        return ready

    def _receive_pending(self) -> None:
        """Receive all pending answers, so that another request can be sent."""
        while self._pipeline.has_pending:
            self._receive_next_block()

    def _receive_next_block(self) -> None:
        if self._pipeline.receive_block():
            self.close()

    def call(self, program: Program | None, function: str, args: Arguments, *, keep: bool) -> Reply:
        """Call a function of a program (None: the main one). Raises StudentFault."""
        refusal = self._refusal_of_dead_function(function)
        if refusal is not None:
            raise refusal
        if program is None:
            self._receive_pending()
        self._answer_count += 1
        try:
            return (program or self.program).call(function, *args, return_arguments=keep)
        except StudentFault as fault:
            self._record_fault(program, function, fault)
            raise

    def call_many(
        self, program: Program | None, function: str, calls: Iterable[Arguments], *, faults: int | None
    ) -> Iterator[Answer]:
        """Yield the answers of `Program.call_many` of a program (None: the main one)."""
        refusal = self._refusal_of_dead_function(function)
        if refusal is not None:
            return iter((refusal,))
        return self.watch_answers(program, function, self._start_calls(program, function, calls, faults))

    def watch_answers(self, program: Program | None, function: str, answers: Iterator[Answer]) -> Iterator[Answer]:
        """Yield the same answers, and record their fatal faults."""
        for answer in answers:
            self.count_answer(program, function, answer)
            yield answer

    def count_answer(self, program: Program | None, function: str, answer: Answer) -> None:
        """Count an answer of a program, and record a fatal fault."""
        self._answer_count += 1
        if isinstance(answer, StudentFault):
            self._record_fault(program, function, answer)

    def is_callable(self, function: str) -> bool:
        """Whether a function may still be called."""
        return function not in self._dead_functions

    def _start_calls(
        self, program: Program | None, function: str, calls: Iterable[Arguments], faults: int | None
    ) -> Iterator[Answer]:
        if program is None:
            self._receive_pending()
        try:
            return (program or self.program).call_many(function, calls, faults=faults)
        except StudentFault as fault:
            return iter((fault,))

    def _refusal_of_dead_function(self, function: str) -> StudentFault | None:
        """Return the fault that stands for calls of a function that is no longer called; None if it still is."""
        before = self._dead_functions.get(function)
        if before is None:
            return None
        return StudentFault(before.outcome, f"{function} n'est pas rappelée : {before.message}", fatal=True)

    def _record_fault(self, program: Program | None, function: str, fault: StudentFault) -> None:
        if fault.fatal:
            self._dead_functions[function] = fault
            self._close_main(program)

    def _close_main(self, program: Program | None) -> None:
        if self._program is not None and program in (None, self._program):
            self.close()

    def announce_launches(self, launches: int) -> None:
        """Announce further launches of the file, so that they can be prepared."""
        self._announced += launches
        if self._announced and isinstance(self.programs, PreparablePrograms):
            self.programs.prepare(self._source, self._kit, self._announced)

    @contextmanager
    def side_program(self, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Iterator[Program]:
        """Yield the same file started on another map, closed after the block; the batches `ahead` travel with it."""
        self._side_programs += 1
        self._announced = max(0, self._announced - 1)
        program = self._start_within_limit(kit, self._side_programs, MAX_SIDE_PROGRAMS, ahead)
        try:
            yield program
        finally:
            program.close()

    def freeze_stdout(self) -> None:
        """Show no later prints of the program, unless it has printed nothing so far."""
        self._receive_pending()
        if self._program is not None:
            self.stdout = self.stdout or self._program.stdout()

    def close(self) -> None:
        """Keep the printed text and close the main program."""
        if self._program is not None:
            self._pipeline.discard_pending()
            self.stdout = self.stdout or self._program.stdout()
            self._program.close()
            self._program = None
