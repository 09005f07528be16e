"""The job that regrades submissions: each run takes the next one of a regrade."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import internal_error_verdict
from server.course.models import Course
from server.gradebook.schemas import GradingResult
from server.grading.grading_task import GradeFunction, GradingInput, load_grading_input
from server.queue.interfaces import GiveUpHandler, Lease, Queue
from server.regrades import repository, service
from server.regrades.service import REGRADE_JOB

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class RegradeAttemptInput:
    """Input to grade one attempt of a regrade, with its original seed."""

    regrade_id: UUID
    item_id: UUID
    file: GradingInput
    needs: str | None


class RegradeTask:
    """Implements `server.queue.interfaces.Task`."""

    def __init__(self, course: Course, queue: Queue, grade: GradeFunction) -> None:
        self._course, self._queue, self._grade = course, queue, grade
        self.give_up = _give_up_handler(course, queue)

    def read(self, db: Session, lease: Lease) -> RegradeAttemptInput | None:
        """Load the next attempt; None when none is left, or the regrade was stopped."""
        return _load_next_attempt(db, self._course, lease)

    def run(self, work: RegradeAttemptInput) -> GradingResult:
        return GradingResult(self._grade(work.file), work.file.started_at)

    def record(self, db: Session, work: RegradeAttemptInput, result: GradingResult) -> None:
        service.record_grading(db, self._queue, work.regrade_id, work.item_id, result, work.needs)


def _load_next_attempt(db: Session, course: Course, lease: Lease) -> RegradeAttemptInput | None:
    row = repository.load_next_item_to_grade(db, UUID(lease.key))
    if row is None:
        return None
    item, submission, _ = row
    return RegradeAttemptInput(
        item.regrade_id, item.id, load_grading_input(db, course, submission, lease.started_at), lease.required_version
    )


def give_up_handlers(course: Course, queue: Queue) -> Mapping[str, GiveUpHandler]:
    """Return the handlers for processes that recover jobs without grading."""
    return {REGRADE_JOB: _give_up_handler(course, queue)}


def _give_up_handler(course: Course, queue: Queue) -> GiveUpHandler:
    """Return the handler that records an internal error, so that the regrade goes on with the other attempts."""

    def give_up(db: Session, lease: Lease) -> None:
        work = _load_next_attempt(db, course, lease)
        if work is None:
            return
        file = work.file
        log.error("regrade %s: submission %s of %s given up", work.regrade_id, file.submission_id, file.exercise)
        verdict = internal_error_verdict(file.exercise, course.version_of_exercise(file.exercise), file.seed)
        graded = GradingResult(Judgement(verdict), lease.started_at)
        service.record_grading(db, queue, work.regrade_id, work.item_id, graded, work.needs)

    return give_up
