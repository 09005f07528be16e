"""What goes into the room, and what comes out of it."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from uuid import UUID

from server.regrades.differences import VerdictDifference
from server.regrades.models import Regrade, RegradePolicy


@dataclass(frozen=True)
class RegradeInput:
    """What a teacher asks to have graded anew: of the whole class, or of an assignment, or of a student."""

    exercise: str
    policy: RegradePolicy
    assignment: UUID | None = None
    student: UUID | None = None


class RegradeState(StrEnum):
    """How far a regrade is."""

    running = "running"
    ready = "ready"
    applied = "applied"
    undone = "undone"
    stopped = "stopped"


@dataclass(frozen=True)
class RegradeProgress:
    """How many attempts are graded anew, of how many. `done` in the sense of who watches: nothing more will come."""

    state: RegradeState
    graded: int
    total: int

    @property
    def done(self) -> bool:
        return self.state is not RegradeState.running


@dataclass(frozen=True)
class RegradedAttempt:
    """An attempt of a regrade. A score, in [0, 1], is None for an error of ours; `after_id` too while it waits."""

    item_id: UUID
    submission_id: UUID
    account_id: UUID
    sent_at: datetime
    counted: bool
    current_id: UUID | None
    before_id: UUID
    before: float | None
    after_id: UUID | None
    after: float | None
    version: str | None
    differences: tuple[VerdictDifference, ...]
    is_applied: bool

    @property
    def failed(self) -> bool:
        return self.after_id is not None and self.after is None


class MarkOutcome(StrEnum):
    """What a regrade does to a student's mark. `kept`: the new version gives less, and the policy keeps the better."""

    gains = "gains"
    loses = "loses"
    kept = "kept"
    same = "same"


@dataclass(frozen=True)
class MarkChange:
    """A student's points out of 20, before and once the regrade is applied; None where nothing counts.

    `anew` is what the new gradings alone would make. `submission_id` is the attempt that `why` is about, None without
    any. `failed` and `waiting` count attempts, `since` those that were sent after the regrade was begun.
    """

    student: UUID
    before: float | None
    after: float | None
    new_only: float | None
    outcome: MarkOutcome
    submission_id: UUID | None
    differences: tuple[VerdictDifference, ...]
    attempts: int
    failed: int
    waiting: int
    sent_since: int = 0


@dataclass(frozen=True)
class RegradePreview:
    """A regrade as it stands, with what it does to each student whom it concerns."""

    regrade: Regrade
    progress: RegradeProgress
    changes: tuple[MarkChange, ...]


@dataclass(frozen=True)
class AppliedRegrade:
    """What the author of an attempt is told of the regrade that has its new grading count; scores as in `Copy`."""

    applied_at: datetime
    before: float | None
    after: float | None
    differences: tuple[VerdictDifference, ...]


@dataclass(frozen=True)
class OutdatedExercise:
    """How many attempts at an exercise no grading of its present version has, and of how many students."""

    exercise: str
    attempts: int
    students: int
