"""Piggyback calls: the probes of a mistake travel with the next exchange, so that they cost no round trip of their own.

The program must be stateless (`stateless`): its answers are then those of a fresh launch. Answers that may depend on
the time, memory or bytes that were left are discarded, and a fresh launch is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from graders.core.code.pipelining import fatal_fault
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, Reply
from graders.core.contract.rows import ArrayReplies

#: Seconds for all answers, beyond which they are discarded: a fresh launch may have a shorter limit.
MAX_ANSWER_SECONDS = 0.5
#: Seconds that the queued calls may be expected to take.
MAX_EXPECTED_SECONDS = 0.1
#: Seconds after which a program that hangs is not probed again.
HANG_SECONDS = 2.0


class PiggybackCalls:
    """Batches that are queued for the next exchange, then their answers."""

    def __init__(self, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._queued: Sequence[PlannedCalls] = ()
        self._answers: dict[PlannedCalls, Sequence[Answer]] = {}
        self._sent_at = 0.0

    def queue(self, batches: Sequence[PlannedCalls]) -> None:
        self._queued = batches

    def take_queued(self, seconds_per_call: float) -> Sequence[PlannedCalls]:
        """Remove and return the queued batches; none where they would take too long for this exchange."""
        if seconds_per_call * sum(len(batch.calls) for batch in self._queued) > MAX_EXPECTED_SECONDS:
            return ()
        batches, self._queued, self._sent_at = self._queued, (), self._clock()
        return batches

    def store_answers(self, answers_by_batch: Mapping[PlannedCalls, Sequence[Answer]]) -> None:
        """Keep the answers if all of them are trustworthy, or those before the point where the program hangs."""
        elapsed = self._clock() - self._sent_at
        trusted = {batch: answers if _are_trustworthy(answers) else () for batch, answers in answers_by_batch.items()}
        hung = elapsed > HANG_SECONDS and any(map(_ends_with_timeout, answers_by_batch.values()))
        if hung or (elapsed <= MAX_ANSWER_SECONDS and all(trusted.values())):
            self._answers = trusted

    def stored_answers(self, batch: PlannedCalls) -> Sequence[Answer] | None:
        return self._answers.get(batch)


def _ends_with_timeout(answers: Sequence[Answer]) -> bool:
    fault = fatal_fault(answers) if answers else None
    return fault is not None and fault.outcome is Outcome.TIMEOUT


def _are_trustworthy(answers: Sequence[Answer]) -> bool:
    """Whether a stateless program gives these answers under any limits."""
    return isinstance(answers, ArrayReplies) or (bool(answers) and all(map(_is_trustworthy, answers)))


def _is_trustworthy(answer: Answer) -> bool:
    if isinstance(answer, Reply):
        return True
    raised = answer.outcome is Outcome.RUNTIME_ERROR and answer.exception not in (None, MemoryError.__name__)
    return not answer.fatal and (raised or answer.outcome is Outcome.MISSING_FUNCTION)
