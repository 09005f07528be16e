"""A class with assignments, and attempts that have been graded: rows, without a grader."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any
from uuid import UUID

from server.assignments.models import AssignedExercise, Assignment, EndedBy, Exemption, Sitting
from server.classes.models import SchoolClass
from server.database import Database
from server.gradebook import service as gradebook
from server.gradebook.models import Grading
from server.identity.models import Account, Role
from server.submissions.models import Submission
from tests.support.classes import new_class, seat
from tests.support.service import new_account

DAY = timedelta(days=1)
OPENS = datetime(2026, 3, 2, 8, tzinfo=UTC)
DUE, CLOSES, AFTER = OPENS + 7 * DAY, OPENS + 10 * DAY, OPENS + 20 * DAY
POSES, ODOMETRY = "l20/poses", "l20/calcul_odometrie"


@dataclass
class Term:
    """A class and what its students have sent."""

    database: Database
    teacher: Account
    made: SchoolClass

    @staticmethod
    def begin(database: Database, teacher: Account | None = None) -> Term:
        teacher = teacher or new_account(database, Role.teacher, "Mme Martin")
        return Term(database, teacher, new_class(database, teacher))

    def student(self, given: str, family: str, **values: Any) -> Account:
        account = new_account(self.database, name=f"{given} {family}")
        return seat(self.database, self.made, account, given_name=given, family_name=family, **values)

    def assignment(self, title: str = "DM 1", exercises: dict[str, float] | None = None, **values: Any) -> Assignment:
        row = {"opens_at": OPENS, "due_at": DUE, "closes_at": CLOSES, **values}
        with self.database.write() as db:
            one = Assignment(class_id=self.made.id, title=title, **row)
            db.add(one)
            db.flush()
            for place, (name, weight) in enumerate((exercises or {POSES: 1.0, ODOMETRY: 1.0}).items()):
                db.add(AssignedExercise(assignment_id=one.id, exercise=name, position=place, weight=weight))
        return one

    def exempt(self, assignment: Assignment, student: Account, **values: Any) -> None:
        with self.database.write() as db:
            db.add(Exemption(assignment_id=assignment.id, account_id=student.id, **values))

    def sit(self, test: Assignment, student: Account, ended: datetime | None = None) -> None:
        """Has a student sit a test from its opening on."""
        by = None if ended is None else EndedBy.student
        row = {"began_at": test.opens_at, "handed_in_at": ended, "ended_by": by}
        with self.database.write() as db:
            db.add(Sitting(assignment_id=test.id, account_id=student.id, **row))

    def send(
        self, student: Account, exercise: str, points: float, at: datetime = OPENS + DAY, diagnosis: str | None = None
    ) -> UUID:
        """An attempt that got so many points out of 20; its name."""
        with self.database.write() as db:
            source = f"# {points}\n".encode()
            one = Submission(
                account_id=student.id, exercise=exercise, source=source, digest=str(points), seed=1, created_at=at
            )
            db.add(one)
            db.flush()
            name = one.id
        self.grade(name, points, diagnosis)
        return name

    def grade(self, submission: UUID, points: float, diagnosis: str | None = None) -> UUID:
        """Another grading of an attempt, that counts from now on; its name."""
        outcome = "ok" if points == 20 else "wrong_answer"
        with self.database.write() as db:
            made = Grading(
                submission_id=submission, exercise_version="v1", outcome=outcome, score=points / 20, seed=1,
                started_at=OPENS, finished_at=OPENS, verdict={}, figures={},
                diagnosis=diagnosis,
            )  # fmt: skip
            db.add(made)
            db.flush()
            gradebook.set_counting_grading(db, submission, made.id)
            return made.id
