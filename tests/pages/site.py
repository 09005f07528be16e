"""A browser on the application, a worker that writes the verdicts it is told to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from starlette.testclient import TestClient

from graders.core.contract.verdict import Outcome
from server.base.provided import provided_to
from server.base.settings import Settings
from server.course import Course
from server.database import Database, utc_now
from server.gradebook.schemas import Graded
from server.grading.task import GradingTask, SentFile
from server.identity import service as accounts
from server.queue.port import NoSignals
from server.queue.service import TableQueue
from server.queue.worker import Worker
from server.submissions.service import GRADE

PAGE = "/m9/exercices/a"
CHECK = {
    "id": "simple",
    "title": "Des nombres simples",
    "passed": False,
    "points": 0,
    "max_points": 20,
    "message": "On attend 4.",
    "counterexample": {"inputs": {"x": [2, 0.5]}, "expected": [4, 1], "got": [2, 1]},
    "hint": "Que vaut le double de 2 ?",
    "figure": "simple",
}


def verdict(outcome: str = "wrong_answer", points: float = 0.0, **changes: Any) -> dict[str, Any]:
    """A verdict of the contract's shape, with one check."""
    passed = outcome == "ok"
    check = {**CHECK, "passed": passed, "points": points}
    if passed:
        check |= {"message": "", "counterexample": None, "hint": None, "figure": None}
    return {
        "exercise": "m9/a",
        "exercise_version": "abc",
        "outcome": outcome,
        "score": points / 20,
        "points": points,
        "max_points": 20,
        "checks": [check],
        "diagnosis": None,
        "stdout": "",
        "seed": 123,
        "timings": {"total_ms": 12.0},
        **changes,
    }


def graded_as(result: dict[str, Any], sent: SentFile) -> Graded:
    """What is recorded where a grader has given this verdict."""
    ours = result["outcome"] == Outcome.INTERNAL_ERROR
    return Graded(
        exercise_version=result["exercise_version"],
        outcome=Outcome(result["outcome"]),
        score=None if ours else result["score"],
        diagnosis=result["diagnosis"]["id"] if result["diagnosis"] else None,
        seed=result["seed"],
        started_at=sent.started_at,
        finished_at=utc_now(),
        timings=result["timings"],
        verdict=result,
        figures={},
    )


@dataclass
class Site:
    """A browser on the application; `grade` plays the worker."""

    client: TestClient
    database: Database

    def get(self, path: str, status: int = 200) -> str:
        answer = self.client.get(path)
        assert answer.status_code == status, answer.text
        return answer.text

    def submit(self, code: str = "x = 1") -> str:
        """Send as a script does; the address of the attempt's page."""
        answer = self.client.post(f"{PAGE}/soumissions", data={"code": code}, headers={"Accept": "application/json"})
        assert answer.status_code == 202, answer.text
        return str(answer.json()["page"])

    def grade(self, result: dict[str, Any]) -> None:
        app: Any = self.client.app
        task = GradingTask(provided_to(app, Course), lambda sent: graded_as(result, sent))
        queue = TableQueue(NoSignals())
        assert Worker(self.database, queue, provided_to(app, Settings), {GRADE: task}).step()

    def attempt(self, code: str, result: dict[str, Any]) -> str:
        page = self.submit(code)
        self.grade(result)
        return page

    def another(self) -> Site:
        """Somebody else's browser."""
        return Site(TestClient(self.client.app), self.database)

    def become_teacher(self) -> None:
        with self.database.write() as db:
            token = accounts.invite_first_teacher(db)
        form = {"name": "Mme Martin", "login": "martin", "password": "une phrase assez longue"}
        assert self.client.post(f"/bienvenue/{token}", data=form).status_code == 200
