"""End of a test: saved work that was not submitted is submitted in its student's name, so that it counts."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from server.assignments import feedback, repository, sitting_repository
from server.assignments.models import Assignment, EndedBy, SavedWork, Sitting
from server.assignments.rules import Rules, is_sitting_running, rules_in_force
from server.classes import repository as classes
from server.course import Course
from server.database import Database, utc_now
from server.identity import repository as identity
from server.identity.models import Account
from server.submissions import repository as stored
from server.submissions.service import SubmissionService

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class SittingCollector:
    """Several processes may run it at once: one of them ends each sitting, in its own transaction."""

    course: Course
    submissions: SubmissionService

    def hand_in(self, db: Session, assignment: Assignment, account_id: UUID, now: datetime) -> None:
        """End a student's sitting at their request; one that has ended stays as it is."""
        sitting, rules = self._lock_sitting(db, assignment, account_id)
        if sitting is None or sitting.ended_by == EndedBy.student:
            return
        if is_sitting_running(rules, sitting, now):
            self._end_and_submit_saved_work(
                db, assignment, sitting, max(now, utc_now()), EndedBy.student
            )  # after what went before it
        else:
            self._end_by_time(db, assignment, sitting, rules, now)
        feedback.clear_holds_memo(db)

    def end_expired_sittings(self, database: Database, now: datetime) -> int:
        """End every sitting whose time is over; return how many. Failures are left for the next time."""
        with database.read() as db:
            unfinished = sitting_repository.load_unfinished_sittings(db)
            exemptions = (
                repository.load_exemptions(db, {work.assignment.id for work in unfinished}) if unfinished else {}
            )
        ended = 0
        for work in unfinished:
            class_exemptions = exemptions.get(work.assignment.id, ())
            rules = rules_in_force(work.assignment, class_exemptions, work.sitting.account_id, work.groups)
            if is_sitting_running(rules, work.sitting, now):
                continue
            try:
                with database.write() as db:
                    ended += self.end_sitting_if_expired(db, work.assignment, work.sitting.account_id, now)
            except SQLAlchemyError:
                log.exception("a test of %s could not be collected; trying again later", work.sitting.account_id)
        return ended

    def end_sitting_if_expired(self, db: Session, assignment: Assignment, account_id: UUID, now: datetime) -> bool:
        """End a sitting if its time is over and nobody has ended it yet."""
        sitting, rules = self._lock_sitting(db, assignment, account_id)
        if sitting is None or sitting.handed_in_at is not None or is_sitting_running(rules, sitting, now):
            return False
        self._end_by_time(db, assignment, sitting, rules, now)
        return True

    def _lock_sitting(self, db: Session, assignment: Assignment, account_id: UUID) -> tuple[Sitting | None, Rules]:
        sitting = sitting_repository.lock_sitting(db, assignment.id, account_id)
        membership = classes.find_membership(db, assignment.class_id, account_id)
        class_exemptions = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
        return sitting, rules_in_force(
            assignment, class_exemptions, account_id, membership.groups if membership else ()
        )

    def _end_by_time(self, db: Session, assignment: Assignment, sitting: Sitting, rules: Rules, now: datetime) -> None:
        self._end_and_submit_saved_work(
            db, assignment, sitting, rules.latest_sitting_end(sitting.began_at) or now, EndedBy.time
        )

    def _end_and_submit_saved_work(
        self, db: Session, assignment: Assignment, sitting: Sitting, ended_at: datetime, by: EndedBy
    ) -> None:
        account = identity.find_account(db, sitting.account_id)
        assert account is not None  # a sitting goes with its account
        for saved in sitting_repository.load_saved_work(db, assignment.id, account.id):
            self._submit_saved_work(db, account, saved, ended_at)
        sitting_repository.end_sitting(db, sitting, ended_at, by)

    def _submit_saved_work(self, db: Session, account: Account, saved: SavedWork, end: datetime) -> None:
        """Submit saved work, unless it was submitted or anything was submitted after it was saved."""
        exercise = self.course.exercises.get(saved.exercise)
        if exercise is None:
            log.warning("%s has left the course: what was saved in a test is kept, and not graded", saved.exercise)
            return
        last_submission = stored.find_latest_submission(db, account.id, saved.exercise)
        if last_submission is not None and (
            last_submission.created_at >= saved.saved_at or last_submission.source == saved.source
        ):
            return
        submitted_at = min(saved.saved_at, end)
        self.submissions.submit_saved_work(
            db, account, saved.exercise, saved.source, submitted_at, answers=exercise.answers is not None
        )
