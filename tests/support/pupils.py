"""A student who sits a test, and whose programs are graded in the sandbox."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from server.assignments import sitting_repository, sittings
from server.assignments.models import EndedBy, Mode
from server.course import Course
from server.database import utc_now
from server.grading.grading_task import GradingInput
from server.grading.sandbox_grader import SandboxGrader
from server.identity.models import Role
from server.sandbox import Sandbox
from tests.support.classes import assign, new_class, person, seat
from tests.support.service import Site


class Pupil:
    """A student of a class with a test of `poses`, whose programs are graded in the sandbox."""

    def __init__(self, site: Site, course: Course, sandbox: Sandbox) -> None:
        self.site, self.who = site, person(site)
        made = new_class(site.database, person(site, Role.teacher).account)
        seat(site.database, made, self.who.account)
        self.test = assign(site.database, made, "l20/poses", mode=Mode.test)
        self.inputs: list[GradingInput] = []
        grader = SandboxGrader(course, sandbox)

        def grade(work: GradingInput) -> Any:
            self.inputs.append(work)
            return grader.grade(work.exercise, work.source, work.seed, own=work.own, tested=work.tested)

        self.worker = site.worker_with(grade)

    def begin(self, at: datetime | None = None) -> None:
        with self.site.database.write() as db:
            sittings.begin_sitting(db, self.test, self.who.id, (), at or utc_now())

    def hand_in(self) -> None:
        with self.site.database.write() as db:
            sitting = sitting_repository.load_sitting(db, self.test.id, self.who.id)
            assert sitting is not None
            sitting_repository.end_sitting(db, sitting, utc_now(), EndedBy.student)

    def submit(self, code: str, exercise: str = "l20/slam_graphe") -> dict[str, Any]:
        """Return the verdict."""
        verdict: dict[str, Any] = self.send(code, exercise)["verdict"]
        return verdict

    def send(self, code: str, exercise: str) -> dict[str, Any]:
        """Return the submission as the API shows it once it is graded."""
        body = {"exercise": exercise, "code": code}
        sent = self.site.client.post("/api/v1/submissions", json=body, headers=self.who.headers)
        assert sent.status_code == 202, sent.text
        self.worker.run_one()
        answer: dict[str, Any] = self.site.client.get(sent.json()["url"], headers=self.who.headers).json()
        return answer
