"""The interface of every grader, and the sample submissions by which it is checked."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import Protocol

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Programs


@dataclass(frozen=True)
class KnownSubmission:
    """A submission whose verdict is known in advance.

    It must get `outcome`, or less than full marks where that is None, and the diagnosis `diagnosis` where there is one.
    `rounds` is the number of seeds on which it is tried.
    """

    subject: str
    source_for_seed: Callable[[int], bytes]
    outcome: Outcome | None = None
    diagnosis: str | None = None
    rounds: int = 1


#: From a judgement without a diagnosis to a context within which the diagnosis is sought.
WhileNaming = Callable[[Judgement], AbstractContextManager[None]]


def no_early_verdict(judgement: Judgement) -> AbstractContextManager[None]:
    """Show nothing before the whole judgement is there."""
    return nullcontext()


class Grader(Protocol):
    """Grades one exercise."""

    @property
    def exercise(self) -> str: ...

    def grade(
        self,
        source: bytes,
        programs: Programs,
        *,
        seed: int,
        version: str,
        while_naming: WhileNaming = no_early_verdict,
    ) -> Judgement:
        """Return the judgement of a submission. An exception raised here is our own fault.

        Where the checks have ended and the name of the mistake is still sought, that is done within `while_naming`,
        which receives the judgement without it.
        """

    def warm_up(self) -> None:
        """Warm up: do once everything that is slow the first time."""

    def known_submissions(self) -> Iterator[KnownSubmission]:
        """Yield the reference, then every catalogued mistake and every specimen."""

    def mistake_ids(self) -> frozenset[str]:
        """Return the ids of the misconceptions that it can name."""
