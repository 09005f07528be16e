"""The end of a test: what was saved and not sent is sent in its student's name, so that it counts."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from server.assignments import feedback, repository, sitting_repository
from server.assignments.models import Assignment, EndedBy, SavedWork, Sitting
from server.assignments.rules import Rules, rules_in_force
from server.classes import repository as classes
from server.course import Course
from server.database import Database, utc_now
from server.identity import repository as identity
from server.identity.models import Account
from server.submissions import repository as stored
from server.submissions.service import Submissions

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class SittingCollector:
    """For several processes at once: each sitting is ended in a transaction of its own, by one of them."""

    course: Course
    submissions: Submissions

    def hand_in(self, db: Session, assignment: Assignment, account_id: UUID, now: datetime) -> None:
        """Ends a student's sitting at their word; one that has ended already stays as it is."""
        sitting, rules = self._locked(db, assignment, account_id)
        if sitting is None or sitting.ended_by == EndedBy.student:
            return
        if feedback.is_sitting_running(rules, sitting, now):
            self._end(db, assignment, sitting, max(now, utc_now()), EndedBy.student)  # after what went before it
        else:
            self._end_by_time(db, assignment, sitting, rules, now)
        feedback.forget_holds(db)

    def collect_expired(self, database: Database, now: datetime) -> int:
        """Ends every sitting whose time is over; how many. What fails is left for the next time."""
        with database.read() as db:
            waiting = sitting_repository.load_unfinished_sittings(db)
            differences = repository.load_exemptions(db, {one.assignment.id for one in waiting}) if waiting else {}
        ended = 0
        for one in waiting:
            told = differences.get(one.assignment.id, ())
            rules = rules_in_force(one.assignment, told, one.sitting.account_id, one.groups)
            if feedback.is_sitting_running(rules, one.sitting, now):
                continue
            try:
                with database.write() as db:
                    ended += self.collect_if_expired(db, one.assignment, one.sitting.account_id, now)
            except SQLAlchemyError:
                log.exception("a test of %s could not be collected; trying again later", one.sitting.account_id)
        return ended

    def collect_if_expired(self, db: Session, assignment: Assignment, account_id: UUID, now: datetime) -> bool:
        """Ends a sitting if its time is over and nobody has ended it yet."""
        sitting, rules = self._locked(db, assignment, account_id)
        if sitting is None or sitting.handed_in_at is not None or feedback.is_sitting_running(rules, sitting, now):
            return False
        self._end_by_time(db, assignment, sitting, rules, now)
        return True

    def _locked(self, db: Session, assignment: Assignment, account_id: UUID) -> tuple[Sitting | None, Rules]:
        sitting = sitting_repository.lock_sitting(db, assignment.id, account_id)
        membership = classes.find_membership(db, assignment.class_id, account_id)
        told = repository.load_exemptions(db, [assignment.id]).get(assignment.id, ())
        return sitting, rules_in_force(assignment, told, account_id, membership.groups if membership else ())

    def _end_by_time(self, db: Session, assignment: Assignment, sitting: Sitting, rules: Rules, now: datetime) -> None:
        self._end(db, assignment, sitting, rules.end_of_sitting(sitting.began_at) or now, EndedBy.time)

    def _end(self, db: Session, assignment: Assignment, sitting: Sitting, when: datetime, by: EndedBy) -> None:
        account = identity.find_account(db, sitting.account_id)
        assert account is not None  # a sitting goes with its account
        for saved in sitting_repository.load_saved_work(db, assignment.id, account.id):
            self._send(db, account, saved, when)
        sitting_repository.end_sitting(db, sitting, when, by)

    def _send(self, db: Session, account: Account, saved: SavedWork, end: datetime) -> None:
        """What is saved, unless it was sent, or something else was sent after it was saved."""
        exercise = self.course.exercises.get(saved.exercise)
        if exercise is None:
            log.warning("%s has left the course: what was saved in a test is kept, and not graded", saved.exercise)
            return
        last = stored.latest(db, account.id, saved.exercise)
        if last is not None and (last.created_at >= saved.saved_at or last.source == saved.source):
            return
        when = min(saved.saved_at, end)
        self.submissions.submit_saved(
            db, account, saved.exercise, saved.source, when, answers=exercise.answers is not None
        )
