"""Grading a submission, as one kind of job."""

import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import internal_error_verdict
from server.base import logs, traces
from server.course.models import Course
from server.course.reuse import Own
from server.gradebook import importable_files
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.limits import service as limits
from server.queue.interfaces import GiveUpHandler, Lease
from server.submissions import repository as submissions
from server.submissions.models import Submission
from server.submissions.repository import GradingRow
from server.submissions.service import GRADE

log = logging.getLogger(__name__)

#: The parts of a grading that its verdict times, in their order.
STEPS = ("checks", "diagnosis")


@dataclass(frozen=True)
class GradingInput:
    """What it takes to grade one submission; `own`: the files of its author that it may import from."""

    submission_id: UUID
    exercise: str
    source: bytes
    seed: int
    started_at: datetime
    own: Own = field(default_factory=dict)


def load_grading_input(
    db: Session, course: Course, submission: Submission | GradingRow, started_at: datetime
) -> GradingInput:
    """A submission, with the earlier files of its author that it may import from."""
    own = importable_files.load_importable_files(db, course, submission)
    return GradingInput(submission.id, submission.exercise, submission.source, submission.seed, started_at, own)


GradeFunction = Callable[[GradingInput], Judgement]


class GradingTask:
    """Fills the port `server.queue.interfaces.Task`."""

    def __init__(self, course: Course, grade: GradeFunction) -> None:
        self._course, self._grade = course, grade
        self.give_up = _giving_up(course)

    def read(self, db: Session, lease: Lease) -> GradingInput | None:
        """None when the submission has gone, with its author."""
        submission = submissions.load_grading_row(db, UUID(lease.key))
        if submission is None:
            return None
        return load_grading_input(db, self._course, submission, lease.started_at)

    def run(self, work: GradingInput) -> GradingResult:
        began = time.time_ns()
        judgement = self._grade(work)
        told = judgement.verdict.timings
        traces.record_spans(began, {name: told[f"{name}_ms"] for name in STEPS if f"{name}_ms" in told})
        return GradingResult(judgement, work.started_at)

    def record(self, db: Session, work: GradingInput, result: GradingResult) -> None:
        _record(db, work.submission_id, result)
        outcome = result.verdict.outcome.value
        logs.log_event("verdict", submission=str(work.submission_id), exercise=work.exercise, outcome=outcome)


def give_up_handlers(course: Course) -> Mapping[str, GiveUpHandler]:
    """For whoever takes jobs back without ever grading."""
    return {GRADE: _giving_up(course)}


def _record(db: Session, submission_id: UUID, graded: GradingResult) -> None:
    """Our own failure costs its author nothing: what it took from their allowance comes back with it."""
    account_id = gradebook.record_grading(db, submission_id, graded)
    if account_id is not None and not graded.verdict.outcome.counts:
        limits.give_back_token(db, limits.submission_key(account_id))


def _giving_up(course: Course) -> GiveUpHandler:
    """The end of a submission whose grading has ended its workers too often."""

    def give_up(db: Session, lease: Lease) -> None:
        submission = submissions.by_id(db, UUID(lease.key))
        if submission is None:
            return
        log.error(
            "submission %s of %s: given up (seed %d, %d bytes, digest %s)",
            *(submission.id, submission.exercise, submission.seed, len(submission.source), submission.digest),
        )
        verdict = internal_error_verdict(submission.exercise, course.version_of(submission.exercise), submission.seed)
        _record(db, submission.id, GradingResult(Judgement(verdict), lease.started_at))

    return give_up
