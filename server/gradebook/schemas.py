"""What goes into the gradebook, and what comes out of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any
from uuid import UUID

from graders.core.contract.verdict import Outcome
from server.gradebook.models import Grading
from server.submissions.models import Submission


@dataclass(frozen=True)
class Graded:
    """One grading, to be recorded; `score` is None for an error of ours, `diagnosis` a misconception's name."""

    exercise_version: str
    outcome: Outcome
    score: float | None
    diagnosis: str | None
    seed: int
    started_at: datetime
    finished_at: datetime
    timings: Mapping[str, float]
    verdict: Mapping[str, Any]
    figures: Mapping[str, Any]


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
