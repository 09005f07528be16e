"""A browser on the application, a worker that writes the verdicts it is told to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from graders.core.contract.findings import FigureData, Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.base.app_services import get_service
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from server.grading.grading_task import GradingTask
from server.identity import links
from server.queue.interfaces import NullNotifier
from server.queue.service import TableQueue
from server.queue.worker import Worker
from server.submissions.service import GRADE
from tests.support.client import TestClient

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
PASSED = CheckResult("simple", "Des nombres simples", True, 20, 20)


def verdict(outcome: str = "wrong_answer", points: float = 0.0, **changes: Any) -> dict[str, Any]:
    """The JSON of a verdict with one check, which passes where the outcome is "ok"; `changes` are in its members."""
    check = PASSED if outcome == Outcome.OK else CheckResult.from_json({**CHECK, "points": points})
    made = Verdict("m9/a", "abc", Outcome(outcome), 123, [check], timings={"total_ms": 12.0})
    return {**made.to_json(), **changes}


@dataclass
class SmallSite:
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

    def grade(self, result: dict[str, Any], figures: dict[str, FigureData] | None = None) -> None:
        app: Any = self.client.app
        judgement = Judgement(Verdict.from_json(result), figures or {})
        task = GradingTask(get_service(app, Course), lambda _sent: judgement)
        queue = TableQueue(NullNotifier())
        assert Worker(self.database, queue, get_service(app, Settings), {GRADE: task}).run_one()

    def attempt(self, code: str, result: dict[str, Any]) -> str:
        page = self.submit(code)
        self.grade(result)
        return page

    @property
    def version(self) -> str:
        """The version of the exercise that is served."""
        app: Any = self.client.app
        return get_service(app, Course).exercises["m9/a"].version

    def another(self) -> SmallSite:
        """Somebody else's browser."""
        return SmallSite(TestClient(self.client.app), self.database)

    def become_teacher(self) -> None:
        with self.database.write() as db:
            token = links.create_administrator_invitation(db)
        form = {"name": "Mme Martin", "login": "martin", "password": "une phrase assez longue"}
        assert self.client.post(f"/bienvenue/{token}", data=form).status_code == 200
