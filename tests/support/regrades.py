"""A class whose students have sent things, and a new version of the exercise that thinks otherwise of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from uuid import UUID, uuid4

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.base.settings import Settings
from server.classes.models import SchoolClass
from server.course import Course
from server.database import Database, utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.grading.grading_task import GradingInput, GradingTask
from server.grading.regrade_task import RegradeTask
from server.identity.models import Account, Role
from server.queue.interfaces import Queue
from server.queue.worker import Worker
from server.regrades.models import Regrade, RegradePolicy
from server.regrades.schemas import RegradeInput
from server.regrades.service import REGRADE_JOB, RegradeService
from server.submissions.models import Submission
from server.submissions.service import GRADE
from tests.support.classes import new_class, seat
from tests.support.quick import the_course
from tests.support.service import EXERCISE, QUIET, new_account

#: Points out of 20; None for an error of ours.
Points = float | None


def verdict(points: Points, version: str = "v1", exercise: str = EXERCISE) -> Verdict:
    """Two checks of 10 points, the first one earned first."""
    if points is None:
        return Verdict(exercise, version, Outcome.INTERNAL_ERROR, 1)
    first, second = min(points, 10.0), max(points - 10.0, 0.0)
    checks = [
        CheckResult("a", "L’angle", first == 10.0, first, 10.0),
        CheckResult("b", "La distance", second == 10.0, second, 10.0),
    ]
    return Verdict(exercise, version, Outcome.OK if points == 20.0 else Outcome.WRONG_ANSWER, 1, checks)


@dataclass
class Lesson:
    """A class, its teacher and students; `opinion` is what the new version finds of each submission."""

    database: Database
    settings: Settings
    queue: Queue = QUIET
    exercise: str = EXERCISE
    version: str = "v2"
    opinion: dict[UUID, Points] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.teacher = new_account(self.database, Role.teacher, "Mme Martin")
        self.made: SchoolClass = new_class(self.database, self.teacher)
        self.students: list[Account] = []
        self.regrades = RegradeService(self.course, self.queue)

    @property
    def course(self) -> Course:
        return the_course()

    def arrive(self, count: int = 1) -> Account:
        for _ in range(count):
            name = f"Élève {len(self.students)}"
            self.students.append(seat(self.database, self.made, new_account(self.database, name=name)))
        return self.students[-1]

    def sent(self, student: Account, points: Points, anew: Points = None, source: bytes = b"x = 1\n") -> UUID:
        """An attempt that the old version has graded; `anew` is what the new one will find."""
        with self.database.write() as db:
            values = {"account_id": student.id, "exercise": self.exercise, "source": source, "seed": 1}
            row = Submission(**values, digest=str(uuid4()))
            db.add(row)
            db.flush()
            gradebook.record_grading(
                db, row.id, GradingResult(Judgement(verdict(points, exercise=self.exercise)), utc_now())
            )
        self.opinion[row.id] = anew
        return row.id

    def grade(self, file: GradingInput) -> Judgement:
        points = self.opinion.get(file.submission_id, 20.0)
        return Judgement(verdict(points, self.version, file.exercise), {"b": {"kind": "anew"}})

    @property
    def worker(self) -> Worker:
        anew = RegradeTask(self.course, self.queue, self.grade)
        tasks = {GRADE: GradingTask(self.course, self.grade), REGRADE_JOB: anew}
        return Worker(self.database, self.queue, self.settings, tasks)

    def start(self, policy: RegradePolicy = RegradePolicy.keep_best, **scope: UUID) -> Regrade:
        with self.database.write() as db:
            return self.regrades.start_regrade(
                db, self.made, self.teacher.id, RegradeInput(self.exercise, policy, **scope)
            )

    def work(self) -> int:
        """Until nothing waits; how many jobs that took."""
        done, worker = 0, self.worker
        while worker.run_one():
            done += 1
        return done

    def prepared(self, policy: RegradePolicy = RegradePolicy.keep_best, **scope: UUID) -> Regrade:
        made = self.start(policy, **scope)
        self.work()
        return made
