"""Grading an attempt anew, as one kind of job: a regrade's next, each time."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import internal_error_verdict
from server.course.models import Course
from server.gradebook.schemas import GradingResult
from server.grading.task import Grade, SentFile, sent_file
from server.queue.port import GiveUp, Lease, Queue
from server.regrades import repository, service
from server.regrades.service import REGRADE_JOB

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Regrading:
    """What it takes to grade one attempt of a regrade, with the seed that it had when it was sent."""

    regrade_id: UUID
    item_id: UUID
    file: SentFile
    needs: str | None


class RegradeTask:
    """Fills the port `server.queue.port.Task`."""

    def __init__(self, course: Course, queue: Queue, grade: Grade) -> None:
        self._course, self._queue, self._grade = course, queue, grade
        self.give_up = _giving_up(course, queue)

    def read(self, db: Session, lease: Lease) -> Regrading | None:
        """None when nothing waits any more, or the regrade was stopped."""
        return _next(db, self._course, lease)

    def run(self, work: Regrading) -> GradingResult:
        return GradingResult(self._grade(work.file), work.file.started_at)

    def record(self, db: Session, work: Regrading, result: GradingResult) -> None:
        service.record_grading(db, self._queue, work.regrade_id, work.item_id, result, work.needs)


def _next(db: Session, course: Course, lease: Lease) -> Regrading | None:
    found = repository.load_next_item(db, UUID(lease.key))
    if found is None:
        return None
    item, submission, _ = found
    return Regrading(item.regrade_id, item.id, sent_file(db, course, submission, lease.started_at), lease.needs)


def give_ups(course: Course, queue: Queue) -> Mapping[str, GiveUp]:
    """For whoever takes jobs back without ever grading."""
    return {REGRADE_JOB: _giving_up(course, queue)}


def _giving_up(course: Course, queue: Queue) -> GiveUp:
    """The end of an attempt whose grading has ended its workers too often: the others are graded all the same."""

    def give_up(db: Session, lease: Lease) -> None:
        work = _next(db, course, lease)
        if work is None:
            return
        file = work.file
        log.error("regrade %s: submission %s of %s given up", work.regrade_id, file.submission_id, file.exercise)
        verdict = internal_error_verdict(file.exercise, course.version_of(file.exercise), file.seed)
        graded = GradingResult(Judgement(verdict), lease.started_at)
        service.record_grading(db, queue, work.regrade_id, work.item_id, graded, work.needs)

    return give_up
