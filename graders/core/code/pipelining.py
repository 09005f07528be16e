"""Pipelining of planned calls: requests are sent before their check needs them, and their answers are buffered."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence

from graders.core.contract.program import Answer, Block, PlannedCalls, Program, StudentFault
from graders.core.contract.rows import ArrayReplies


class CallPipeline:
    """Planned batches in the order of the checks. Batches without any answer when a program dies are sent again."""

    def __init__(self) -> None:
        self._plan: dict[PlannedCalls, int] = {}
        self._sent: Sequence[PlannedCalls] = ()
        self._incoming: Iterator[Block] | None = None
        self._current = 0
        self._positions: dict[PlannedCalls, int] = {}
        self._ready: dict[PlannedCalls, deque[Sequence[Answer]]] = {}

    def set_plan(self, plan: Sequence[PlannedCalls]) -> None:
        """Replace the plan, and drop the answers that are buffered for the former one."""
        self._plan, self._ready = {batch: position for position, batch in enumerate(plan)}, {}

    def is_planned(self, batch: PlannedCalls) -> bool:
        return batch in self._plan

    def batches_from(self, batch: PlannedCalls, dead_functions: Collection[str]) -> Sequence[PlannedCalls]:
        """Return this batch and the later ones of the plan, without the functions that are no longer called."""
        start = self._plan[batch]
        return [
            planned
            for planned, position in self._plan.items()
            if position >= start and planned.function not in dead_functions
        ]

    def send(self, program: Program, batches: Sequence[PlannedCalls]) -> None:
        """Send these batches to a program."""
        self._sent, self._incoming, self._current = batches, program.call_batches(batches), 0
        self._positions = {batch: position for position, batch in enumerate(batches)}
        self._ready |= {batch: deque() for batch in batches}

    def ready_blocks(self, batch: PlannedCalls) -> deque[Sequence[Answer]] | None:
        """Return the buffered answers of a batch, block by block; None where it was not sent."""
        return self._ready.get(batch)

    def is_pending(self, batch: PlannedCalls) -> bool:
        """Whether more answers to a batch may arrive."""
        return self._incoming is not None and self._current <= self._positions.get(batch, -1)

    @property
    def has_pending(self) -> bool:
        return self._incoming is not None

    def receive_block(self) -> StudentFault | None:
        """Buffer the next block of answers; return its fatal fault, if it ends the program."""
        assert self._incoming is not None
        block = next(self._incoming, None)
        if block is None:
            self._incoming = None
            return None
        self._current, answers = block
        self._ready[self._sent[self._current]].append(answers)
        fault = fatal_fault(answers)
        if fault is not None:
            self.discard_pending()
        return fault

    def discard_pending(self) -> None:
        """Forget the batches that a program which ended has not begun, so that they are sent again."""
        if self._incoming is not None:
            self._incoming = None
            for batch in self._sent[self._current + 1 :]:
                self._ready.pop(batch, None)


def fatal_fault(answers: Sequence[Answer]) -> StudentFault | None:
    """Return the fault in a block of answers that ends the program."""
    last = None if isinstance(answers, ArrayReplies) else answers[-1]
    return last if isinstance(last, StudentFault) and last.fatal else None
