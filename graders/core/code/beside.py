"""What a program is asked beside what it is asked anyway, so that nobody waits for it alone.

It must be a program that remembers nothing (`stateless`): its answers are then those of one launched afresh.
Where it may not be so, by what time, memory or bytes it had left, they count for nothing, and it is asked again.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, Foreseen, Reply
from graders.core.contract.rows import Replies

#: Of a program that takes longer, answers count for nothing: who asks it by itself may have less patience.
LONGEST = 0.5


class Beside:
    """What waits for the next exchange, then what was answered to it."""

    def __init__(self) -> None:
        self._waiting: Sequence[Foreseen] = ()
        self._told: dict[Foreseen, Sequence[Answer]] = {}
        self._begun = 0.0

    def wait(self, asked: Sequence[Foreseen]) -> None:
        self._waiting = asked

    def begin(self) -> Sequence[Foreseen]:
        """What has waited until now, and is asked."""
        begun, self._waiting, self._begun = self._waiting, (), time.perf_counter()
        return begun

    def take(self, told: Mapping[Foreseen, Sequence[Answer]]) -> None:
        """The answers to all of it."""
        if time.perf_counter() - self._begun <= LONGEST and all(map(_are_its_own, told.values())):
            self._told = dict(told)

    def told(self, asked: Foreseen) -> Sequence[Answer] | None:
        return self._told.get(asked)


def _are_its_own(answers: Sequence[Answer]) -> bool:
    """Whether a program that remembers nothing gives these answers under whatever limits; it has come to give them."""
    return isinstance(answers, Replies) or (bool(answers) and all(map(_is_its_own, answers)))


def _is_its_own(answer: Answer) -> bool:
    if isinstance(answer, Reply):
        return True
    raised = answer.outcome is Outcome.RUNTIME_ERROR and answer.exception not in (None, MemoryError.__name__)
    return not answer.fatal and (raised or answer.outcome is Outcome.MISSING_FUNCTION)
