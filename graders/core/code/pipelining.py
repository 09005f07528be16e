"""What checks ask of a program before their turn comes, and the answers that wait for it."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence

from graders.core.contract.program import Answer, Block, PlannedCalls, Program, StudentFault
from graders.core.contract.rows import ArrayReplies


class CallPipeline:
    """What is foreseen, in the order of the checks. What a program has died before it came to is asked again."""

    def __init__(self) -> None:
        self._plan: dict[PlannedCalls, int] = {}
        self._asked: Sequence[PlannedCalls] = ()
        self._coming: Iterator[Block] | None = None
        self._reached = 0
        self._places: dict[PlannedCalls, int] = {}
        self._ready: dict[PlannedCalls, deque[Sequence[Answer]]] = {}

    def set_plan(self, plan: Sequence[PlannedCalls]) -> None:
        """Begins anew: what was foreseen before has been asked and taken, or never will be."""
        self._plan, self._ready = {one: place for place, one in enumerate(plan)}, {}

    def is_planned(self, asked: PlannedCalls) -> bool:
        return asked in self._plan

    def batches_from(self, asked: PlannedCalls, dead: Collection[str]) -> Sequence[PlannedCalls]:
        """What is to be asked together: this and what comes after, but for the functions that are called no more."""
        here = self._plan[asked]
        return [one for one, place in self._plan.items() if place >= here and one.function not in dead]

    def send(self, program: Program, asked: Sequence[PlannedCalls]) -> None:
        """Has a program answer these."""
        self._asked, self._coming, self._reached = asked, program.call_batches(asked), 0
        self._places = {one: place for place, one in enumerate(asked)}
        self._ready |= {one: deque() for one in asked}

    def ready_blocks(self, asked: PlannedCalls) -> deque[Sequence[Answer]] | None:
        """The answers that are there, as they came together; None where nothing was asked."""
        return self._ready.get(asked)

    def is_pending(self, asked: PlannedCalls) -> bool:
        """May there be others on their way?"""
        return self._coming is not None and self._reached <= self._places.get(asked, -1)

    @property
    def has_pending(self) -> bool:
        return self._coming is not None

    def receive_block(self) -> StudentFault | None:
        """The next answers, put where they are awaited; returned when the last of its program is among them."""
        assert self._coming is not None
        came = next(self._coming, None)
        if came is None:
            self._coming = None
            return None
        self._reached, answers = came
        self._ready[self._asked[self._reached]].append(answers)
        last = fatal_fault(answers)
        if last is not None:
            self.discard_pending()
        return last

    def discard_pending(self) -> None:
        """The program is gone: what it has not come to is as if it had never been asked."""
        if self._coming is not None:
            self._coming = None
            for one in self._asked[self._reached + 1 :]:
                self._ready.pop(one, None)


def fatal_fault(answers: Sequence[Answer]) -> StudentFault | None:
    """The fault, among answers that have come together, after which there are no others of its program."""
    last = None if isinstance(answers, ArrayReplies) else answers[-1]
    return last if isinstance(last, StudentFault) and last.fatal else None
