"""Inputs and results of regrades."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from uuid import UUID

from server.regrades.differences import VerdictDifference
from server.regrades.models import Regrade, RegradePolicy


@dataclass(frozen=True)
class RegradeInput:
    """The attempts to regrade: of the whole class, of an assignment, or of a student."""

    exercise: str
    policy: RegradePolicy
    assignment: UUID | None = None
    student: UUID | None = None


class RegradeState(StrEnum):
    """The state of a regrade."""

    running = "running"
    ready = "ready"
    applied = "applied"
    undone = "undone"
    stopped = "stopped"


@dataclass(frozen=True)
class RegradeProgress:
    """The number of attempts regraded so far, and in all. `done`: no more gradings will come."""

    state: RegradeState
    graded: int
    total: int

    @property
    def done(self) -> bool:
        return self.state is not RegradeState.running


@dataclass(frozen=True)
class RegradedAttempt:
    """An attempt of a regrade. Scores, in [0, 1], are None for internal errors; `after_id` is None while it waits."""

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
    def is_failed(self) -> bool:
        return self.after_id is not None and self.after is None


class MarkOutcome(StrEnum):
    """The effect on a student's mark. `kept`: the new version gives less, and the policy keeps the better grading."""

    gains = "gains"
    loses = "loses"
    kept = "kept"
    same = "same"


@dataclass(frozen=True)
class MarkChange:
    """A student's points out of 20, before and after the regrade is applied; None where nothing counts.

    `new_only`: the points from the new gradings alone. `submission_id` is the attempt that `differences` explain, None
    without any. `failed` and `waiting` count attempts, `sent_since` those sent after the regrade began.
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
    """A regrade with its progress and its effect on each student."""

    regrade: Regrade
    progress: RegradeProgress
    changes: tuple[MarkChange, ...]


@dataclass(frozen=True)
class AppliedRegrade:
    """The applied regrade of an attempt, as its author sees it; scores as in `RegradedAttempt`."""

    applied_at: datetime
    before: float | None
    after: float | None
    differences: tuple[VerdictDifference, ...]


@dataclass(frozen=True)
class OutdatedExercise:
    """An exercise with attempts never graded by its current version: their number, and that of their students."""

    exercise: str
    attempts: int
    students: int
