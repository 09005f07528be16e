"""Inputs and outputs of the gradebook."""

from dataclasses import dataclass, field
from datetime import datetime
from functools import cached_property
from uuid import UUID

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Verdict
from server.assignments.feedback import NO_HOLDS, FeedbackHolds, WithholdingTest
from server.database import utc_now
from server.gradebook.models import Grading
from server.submissions.models import Submission

#: The numbers of different failed attempts after which the hints of an exercise open.
HINT_OPENS_AFTER = (1, 2, 4)


@dataclass(frozen=True)
class GradingResult:
    """A finished grading, to be recorded."""

    judgement: Judgement
    started_at: datetime
    finished_at: datetime = field(default_factory=utc_now)

    @property
    def verdict(self) -> Verdict:
        return self.judgement.verdict


@dataclass(frozen=True)
class Attempt:
    """A submission with the grading that counts, as an account may see it.

    `grading` is None while it waits, and while a test withholds it (`held`). The two look the same to the account, but
    for an internal error (`failed`) and for a file that does not run (`load_error`). `shared`: it was sent by
    somebody with whom the account hands in.
    """

    submission: Submission
    grading: Grading | None
    feedback: FeedbackHolds = NO_HOLDS
    failed: bool = False
    load_error: str = ""
    shared: bool = False

    @property
    def held(self) -> WithholdingTest | None:
        return self.feedback.find_withholding_test(self.submission.created_at)

    @property
    def held_text(self) -> str:
        """The text shown in place of a withheld verdict; empty otherwise."""
        if self.held is None:
            return ""
        sentence = FAILED if self.failed else NOT_LOADED if self.load_error else HELD
        return sentence.format(title=self.held.title, error=self.load_error)

    @property
    def settles_in(self) -> float:
        """Seconds until nothing more is waited for of a withheld attempt, whether it was graded or not.

        How long a grading takes would tell how it ends; only a file that does not run is told of before.
        """
        if self.failed or self.load_error:
            return 0.0
        return max(0.0, LOAD_SECONDS - (utc_now() - self.submission.created_at).total_seconds())

    @cached_property
    def verdict(self) -> Verdict | None:
        """The verdict without what is withheld from the account."""
        if self.grading is None:
            return None
        return self.feedback.remove_withheld_parts(Verdict.from_json(self.grading.verdict))


HELD = "Reçu. Le résultat paraîtra quand l’enseignant publiera ceux du contrôle « {title} »."
#: Seconds after its sending during which a withheld attempt is watched for a file that does not run.
LOAD_SECONDS = 7.0
NOT_LOADED = (
    "Reçu, mais ce fichier ne s’exécute pas en entier. {error} Vous pouvez le corriger et l’envoyer de nouveau tant "
    "que dure le contrôle « {title} » ; le reste paraîtra avec ses résultats."
)
FAILED = (
    "Reçu, mais pas corrigé : c’est une erreur de notre côté, elle ne compte pas contre vous et sera regardée. Tant "
    "que dure le contrôle « {title} », vous pouvez envoyer de nouveau."
)


@dataclass(frozen=True)
class AttemptLine:
    """An attempt in a list. `outcome` and `score` are None while it waits, and while a test withholds them (`held`).

    `failed`: withheld, and it ended as an internal error; `runs`: not withheld, or its file is not known to stop.
    """

    id: UUID
    number: int
    sent_at: datetime
    outcome: str | None
    score: float | None
    held: bool = False
    failed: bool = False
    runs: bool = True


@dataclass(frozen=True)
class AttemptList:
    """Some of an account's attempts at one exercise, newest first; `total` counts all of them."""

    lines: tuple[AttemptLine, ...] = ()
    total: int = 0


@dataclass(frozen=True)
class ExerciseProgress:
    """An account's progress at one exercise. `best`: the best score in [0, 1], None while nothing is graded.

    `attempts` includes those that wait and those that a test withholds; internal errors are left out where known.
    """

    best: float | None
    attempts: int
    succeeded: bool = False


NOTHING_YET = ExerciseProgress(None, 0)
