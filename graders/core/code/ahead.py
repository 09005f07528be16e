"""What checks ask of a program before their turn comes, and the answers that wait for it."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Iterator, Sequence

from graders.core.contract.program import Answer, Block, Foreseen, Program, StudentFault
from graders.core.contract.rows import Replies


class Ahead:
    """What is foreseen, in the order of the checks. What a program has died before it came to is asked again."""

    def __init__(self) -> None:
        self._plan: dict[Foreseen, int] = {}
        self._asked: Sequence[Foreseen] = ()
        self._coming: Iterator[Block] | None = None
        self._reached = 0
        self._places: dict[Foreseen, int] = {}
        self._ready: dict[Foreseen, deque[Sequence[Answer]]] = {}

    def foresee(self, plan: Sequence[Foreseen]) -> None:
        """Begins anew: what was foreseen before has been asked and taken, or never will be."""
        self._plan, self._ready = {one: place for place, one in enumerate(plan)}, {}

    def foresees(self, asked: Foreseen) -> bool:
        return asked in self._plan

    def from_here(self, asked: Foreseen, dead: Collection[str]) -> Sequence[Foreseen]:
        """What is to be asked together: this and what comes after, but for the functions that are called no more."""
        here = self._plan[asked]
        return [one for one, place in self._plan.items() if place >= here and one.function not in dead]

    def begin(self, program: Program, asked: Sequence[Foreseen]) -> None:
        """Has a program answer these."""
        self._asked, self._coming, self._reached = asked, program.together(asked), 0
        self._places = {one: place for place, one in enumerate(asked)}
        self._ready |= {one: deque() for one in asked}

    def ready(self, asked: Foreseen) -> deque[Sequence[Answer]] | None:
        """The answers that are there, as they came together; None where nothing was asked."""
        return self._ready.get(asked)

    def awaits(self, asked: Foreseen) -> bool:
        """May there be others on their way?"""
        return self._coming is not None and self._reached <= self._places.get(asked, -1)

    @property
    def on_the_way(self) -> bool:
        return self._coming is not None

    def take_in(self) -> StudentFault | None:
        """The next answers, put where they are awaited; returned when the last of its program is among them."""
        assert self._coming is not None
        came = next(self._coming, None)
        if came is None:
            self._coming = None
            return None
        self._reached, answers = came
        self._ready[self._asked[self._reached]].append(answers)
        last = end_of(answers)
        if last is not None:
            self.lose()
        return last

    def lose(self) -> None:
        """The program is gone: what it has not come to is as if it had never been asked."""
        if self._coming is not None:
            self._coming = None
            for one in self._asked[self._reached + 1 :]:
                self._ready.pop(one, None)


def end_of(answers: Sequence[Answer]) -> StudentFault | None:
    """The fault, among answers that have come together, after which there are no others of its program."""
    last = None if isinstance(answers, Replies) else answers[-1]
    return last if isinstance(last, StudentFault) and last.fatal else None
