"""What a program is asked beside what it is asked anyway, so that nobody waits for it alone.

It must be a program that remembers nothing (`stateless`): its answers are then those of one launched afresh.
Where it may not be so, by what time, memory or bytes it had left, they count for nothing, and it is asked again.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from graders.core.code.pipelining import fatal_fault
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, Reply
from graders.core.contract.rows import ArrayReplies

#: Of a program that takes longer, answers count for nothing: who asks it by itself may have less patience.
MAX_ANSWER_SECONDS = 0.5
#: Seconds that it may be expected to take from what simplifies a mistake.
MAX_EXPECTED_SECONDS = 0.1
#: After so many, nobody asks a program any more to name its mistake.
HANG_SECONDS = 2.0


class PiggybackCalls:
    """What waits for the next exchange, then what was answered to it."""

    def __init__(self) -> None:
        self._waiting: Sequence[PlannedCalls] = ()
        self._told: dict[PlannedCalls, Sequence[Answer]] = {}
        self._begun = 0.0

    def queue(self, asked: Sequence[PlannedCalls]) -> None:
        self._waiting = asked

    def take_queued(self, pace: float) -> Sequence[PlannedCalls]:
        """What has waited until now, and is asked; what would take long, at so many seconds a call, is for a program of
        its own."""
        if pace * sum(len(one.calls) for one in self._waiting) > MAX_EXPECTED_SECONDS:
            return ()
        begun, self._waiting, self._begun = self._waiting, (), time.perf_counter()
        return begun

    def store_answers(self, told: Mapping[PlannedCalls, Sequence[Answer]]) -> None:
        """The answers to all of it. Where it has hung for long, what came before stands, and the rest is not asked: to
        wait for it once is enough."""
        spent = time.perf_counter() - self._begun
        own = {one: answers if _are_its_own(answers) else () for one, answers in told.items()}
        hung = spent > HANG_SECONDS and any(map(_hangs, told.values()))
        if hung or (spent <= MAX_ANSWER_SECONDS and all(own.values())):
            self._told = own

    def answers(self, asked: PlannedCalls) -> Sequence[Answer] | None:
        return self._told.get(asked)


def _hangs(answers: Sequence[Answer]) -> bool:
    last = fatal_fault(answers) if answers else None
    return last is not None and last.outcome is Outcome.TIMEOUT


def _are_its_own(answers: Sequence[Answer]) -> bool:
    """Whether a program that remembers nothing gives these answers under whatever limits; it has come to give them."""
    return isinstance(answers, ArrayReplies) or (bool(answers) and all(map(_is_its_own, answers)))


def _is_its_own(answer: Answer) -> bool:
    if isinstance(answer, Reply):
        return True
    raised = answer.outcome is Outcome.RUNTIME_ERROR and answer.exception not in (None, MemoryError.__name__)
    return not answer.fatal and (raised or answer.outcome is Outcome.MISSING_FUNCTION)
