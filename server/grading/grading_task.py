"""The job that grades a submission."""

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

#: Timed parts of a grading, in order.
STEPS = ("checks", "diagnosis")


@dataclass(frozen=True)
class GradingInput:
    """Input to grade one submission; `own` holds the author's files that it may import from.

    `tested` are the exercises whose functions of the course it may not get: its author sat tests of them.
    """

    submission_id: UUID
    exercise: str
    source: bytes
    seed: int
    started_at: datetime
    own: Own = field(default_factory=dict)
    tested: frozenset[str] = frozenset()


def load_grading_input(
    db: Session, course: Course, submission: Submission | GradingRow, started_at: datetime
) -> GradingInput:
    """Load a submission's input, with the earlier files of its author that it may import from."""
    own = importable_files.load_importable_files(db, course, submission)
    tested = importable_files.load_exercises_in_sat_tests(db, course, submission)
    return GradingInput(submission.id, submission.exercise, submission.source, submission.seed, started_at, own, tested)


GradeFunction = Callable[[GradingInput], Judgement]


class GradingTask:
    """Implements `server.queue.interfaces.Task`."""

    def __init__(self, course: Course, grade: GradeFunction) -> None:
        self._course, self._grade = course, grade
        self.give_up = _give_up_handler(course)

    def read(self, db: Session, lease: Lease) -> GradingInput | None:
        """Load the submission; None when it was deleted with its author."""
        submission = submissions.load_grading_row(db, UUID(lease.key))
        if submission is None:
            return None
        return load_grading_input(db, self._course, submission, lease.started_at)

    def run(self, work: GradingInput) -> GradingResult:
        started = time.time_ns()
        judgement = self._grade(work)
        timings = judgement.verdict.timings
        traces.record_spans(started, {name: timings[f"{name}_ms"] for name in STEPS if f"{name}_ms" in timings})
        return GradingResult(judgement, work.started_at)

    def record(self, db: Session, work: GradingInput, result: GradingResult) -> None:
        _store_grading_result(db, work.submission_id, result)
        outcome = result.verdict.outcome.value
        logs.log_event("verdict", submission=str(work.submission_id), exercise=work.exercise, outcome=outcome)


def give_up_handlers(course: Course) -> Mapping[str, GiveUpHandler]:
    """Return the handlers for processes that recover jobs without grading."""
    return {GRADE: _give_up_handler(course)}


def _store_grading_result(db: Session, submission_id: UUID, graded: GradingResult) -> None:
    """Record the grading; an internal error gives its author the rate-limit token back."""
    account_id = gradebook.record_grading(db, submission_id, graded)
    if account_id is not None and not graded.verdict.outcome.counts:
        limits.give_back_token(db, limits.submission_bucket_key(account_id))


def _give_up_handler(course: Course) -> GiveUpHandler:
    """Return the handler that records an internal error after too many tries."""

    def give_up(db: Session, lease: Lease) -> None:
        submission = submissions.find_submission(db, UUID(lease.key))
        if submission is None:
            return
        log.error(
            "submission %s of %s: given up (seed %d, %d bytes, digest %s)",
            *(submission.id, submission.exercise, submission.seed, len(submission.source), submission.digest),
        )
        verdict = internal_error_verdict(
            submission.exercise, course.version_of_exercise(submission.exercise), submission.seed
        )
        _store_grading_result(db, submission.id, GradingResult(Judgement(verdict), lease.started_at))

    return give_up
