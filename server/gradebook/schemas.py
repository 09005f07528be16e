"""What goes into the gradebook, and what comes out of it."""

from dataclasses import dataclass, field
from datetime import datetime
from uuid import UUID

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Verdict
from server.database import utc_now
from server.gradebook.models import Grading
from server.submissions.models import Submission


@dataclass(frozen=True)
class Graded:
    """One grading as it ended, to be recorded."""

    judgement: Judgement
    started_at: datetime
    finished_at: datetime = field(default_factory=utc_now)

    @property
    def verdict(self) -> Verdict:
        return self.judgement.verdict


@dataclass(frozen=True)
class Attempt:
    """A submission as its author sees it: what was sent, and the grading that counts (None while it waits)."""

    submission: Submission
    grading: Grading | None


@dataclass(frozen=True)
class AttemptLine:
    """An attempt in a list: `outcome` and `score` are None while it waits."""

    id: UUID
    number: int
    sent_at: datetime
    outcome: str | None
    score: float | None


@dataclass(frozen=True)
class Attempts:
    """Some of an account's attempts at one exercise, newest first, and how many there are in all."""

    lines: tuple[AttemptLine, ...] = ()
    total: int = 0


@dataclass(frozen=True)
class Progress:
    """Where one account stands in one exercise; `best` in [0, 1], None while nothing is graded.

    `attempts` counts those that wait, and no error of ours.
    """

    best: float | None
    attempts: int
    succeeded: bool = False


NOTHING_YET = Progress(None, 0)
