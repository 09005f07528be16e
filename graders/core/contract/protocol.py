"""What a server needs of a grader, whatever the kind of exercise; and what is known of an exercise, to check it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Programs


@dataclass(frozen=True)
class KnownSubmission:
    """A submission of which the verdict is known in advance.

    `write` gives it for a seed. It must get `outcome`, or, where that is None, less than full marks; and be named
    `diagnosis` where there is one. `rounds`: on how many seeds it is worth trying.
    """

    subject: str
    source_for_seed: Callable[[int], bytes]
    outcome: Outcome | None = None
    diagnosis: str | None = None
    rounds: int = 1


class Grader(Protocol):
    """Grades one exercise."""

    @property
    def exercise(self) -> str: ...

    def grade(self, source: bytes, programs: Programs, *, seed: int, version: str) -> Judgement:
        """The verdict of a submission. An exception that leaves it is our own fault."""

    def rehearse(self) -> None:
        """Do once what is slow the first time."""

    def known_submissions(self) -> Iterator[KnownSubmission]:
        """The reference first, then every catalogued mistake and every specimen."""

    def mistake_ids(self) -> frozenset[str]:
        """The ids of the misconceptions that it can name."""
