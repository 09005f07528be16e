"""What goes into the gradebook, and what comes out of it."""

from dataclasses import dataclass, field
from datetime import datetime
from functools import cached_property
from uuid import UUID

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Verdict
from server.assignments.feedback import NO_HOLDS, FeedbackHolds, HoldingTest
from server.database import utc_now
from server.gradebook import verdicts
from server.gradebook.models import Grading
from server.submissions.models import Submission

#: Each hint of an exercise opens after so many changed attempts without success.
HINT_OPENS_AFTER = (1, 2, 4)


@dataclass(frozen=True)
class GradingResult:
    """One grading as it ended, to be recorded."""

    judgement: Judgement
    started_at: datetime
    finished_at: datetime = field(default_factory=utc_now)

    @property
    def verdict(self) -> Verdict:
        return self.judgement.verdict


@dataclass(frozen=True)
class Attempt:
    """A submission as it is seen: what was sent, and the grading that counts.

    None while it waits, and while a test holds it back from who looks (`held`): nothing tells these two apart, but that
    an error of ours has left it ungraded (`failed`).
    """

    submission: Submission
    grading: Grading | None
    feedback: FeedbackHolds = NO_HOLDS
    failed: bool = False

    @property
    def held(self) -> HoldingTest | None:
        return self.feedback.test_holding(self.submission.created_at)

    @property
    def held_text(self) -> str:
        """What there is to say of an attempt whose verdict a test holds back; empty of another one."""
        return "" if self.held is None else (FAILED if self.failed else HELD).format(title=self.held.title)

    @cached_property
    def verdict(self) -> Verdict | None:
        """Without what is held back of it from who looks."""
        if self.grading is None:
            return None
        return self.feedback.redact(verdicts.read(self.grading.id, self.grading.verdict))


HELD = "Reçu. Le résultat paraîtra quand l’enseignant publiera ceux du contrôle « {title} »."
FAILED = (
    "Reçu, mais pas corrigé : c’est une erreur de notre côté, elle ne compte pas contre vous et sera regardée. Tant "
    "que dure le contrôle « {title} », vous pouvez envoyer de nouveau."
)


@dataclass(frozen=True)
class AttemptLine:
    """An attempt in a list: `outcome` and `score` are None while it waits, and while a test holds them back.

    `failed`: held back, and an error of ours has left it ungraded.
    """

    id: UUID
    number: int
    sent_at: datetime
    outcome: str | None
    score: float | None
    held: bool = False
    failed: bool = False


@dataclass(frozen=True)
class Attempts:
    """Some of an account's attempts at one exercise, newest first, and how many there are in all."""

    lines: tuple[AttemptLine, ...] = ()
    total: int = 0


@dataclass(frozen=True)
class Progress:
    """Where one account stands in one exercise; `best` in [0, 1], None while nothing is graded.

    `attempts` counts those that wait, those that a test holds back, and no error of ours that may be told.
    """

    best: float | None
    attempts: int
    succeeded: bool = False


NOTHING_YET = Progress(None, 0)
