"""A teacher who writes exercises, and a worker that tries them in the sandbox."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, TypeVar
from uuid import UUID

import pytest

from graders.core.declared import trial
from graders.core.declared.trial import ExerciseTrial
from graders.core.declared.trial_report import TrialReport
from server.base.app_services import get_service
from server.grading import trial_task
from server.grading.grading_task import GradingInput, GradingTask
from server.grading.sandbox_grader import SandboxGrader, SandboxPrograms
from server.grading.trial_task import DraftTrialTask
from server.grading.tryout_task import ProgramTryoutTask
from server.identity.models import Role
from server.queue.worker import Worker
from server.sandbox import Sandbox
from server.studio.authored import AuthoredExercises
from server.studio.models import AuthoredExercise, ExerciseVersion
from server.studio.service import TRIAL_JOB, TRYOUT_JOB, StudioService
from server.submissions.service import GRADE
from tests.support.classes import Person, person
from tests.support.client import TestClient
from tests.support.quick import the_course
from tests.support.service import Site

T = TypeVar("T")

SOLUTION = """def compter_mots(texte):
    d = {}
    for m in texte.split():
        d[m] = d.get(m, 0) + 1
    return d
"""
FORM: dict[str, Any] = {
    "titre": "Compter les mots",
    "enonce": "Écrivez `compter_mots(texte)`, qui compte les mots.",
    "solution": SOLUTION,
    "v-0-c-0-appel": 'compter_mots("")',
    "v-0-c-0-attendu": "{}",
    "v-0-c-1-appel": 'compter_mots("a b a")',
    "v-0-c-1-attendu": '{"a": 2, "b": 1}',
    "v-0-c-2-appel": 'compter_mots("le  Chat")',
}
MISTAKE = {
    "e-0-titre": "Chaque mot compte une fois",
    "e-0-explication": "Le compte d’un mot déjà vu est perdu.",
    "e-0-question": "Que vaut d[m] au deuxième passage ?",
    "e-0-programme": SOLUTION.replace("d.get(m, 0) + 1", "1"),
}


@dataclass
class Studio:
    """A teacher's browser, and the worker."""

    site: Site
    teacher: Person
    browser: TestClient
    worker: Worker

    def create(self) -> str:
        made = self.browser.post("/mes-exercices", data={"module": "l20"})
        assert made.status_code == 303, made.text
        return str(made.headers["location"])

    def save(self, path: str, **changes: Any) -> Any:
        """Save the form with these fields, and carry out the trial."""
        answer = self.browser.post(path, data={**FORM, **changes})
        self.work()
        return answer

    def work(self) -> None:
        while self.worker.run_one():
            pass

    def publish(self, **changes: Any) -> AuthoredExercise:
        """Publish a new exercise."""
        path = self.create()
        answer = self.save(path, action="publier", **changes)
        assert answer.status_code == 303, answer.text
        exercise = self.stored(path)
        assert exercise.number, self.report(path)
        return exercise

    def stored(self, path: str) -> AuthoredExercise:
        with self.site.database.read() as db:
            return db.get_one(AuthoredExercise, UUID(path.rpartition("/")[2]))

    def versions(self) -> list[ExerciseVersion]:
        with self.site.database.read() as db:
            return list(db.query(ExerciseVersion).order_by(ExerciseVersion.number))

    def report(self, path: str) -> str:
        """Return the words of the panel of the trial."""
        page = self.browser.get(f"{path}/essai")
        assert page.status_code == 200
        return " ".join(re.sub(r"<[^>]*>", " ", page.text).replace("&nbsp;", " ").replace("\u202f", " ").split())


class TrialsOnce(ExerciseTrial):
    """Tries each declaration once in this process: many tests save the same exercise, whose trial starts many programs.

    Nothing that a trial finds depends on the exercise's name, which is drawn at random, nor on its title or statement.
    """

    _outcomes: ClassVar[dict[str, Any]] = {}

    def run(self, data: Mapping[str, Any], starter: str, *, seeds: int = 0, with_changes: bool = True) -> TrialReport:
        run = partial(super().run, data, starter, seeds=seeds, with_changes=with_changes)
        return self._once(run, "run", data, starter, seeds, with_changes)

    def answer_written_cases(self, data: Mapping[str, Any]) -> list[list[str]] | None:
        return self._once(partial(super().answer_written_cases, data), "answer_written_cases", data)

    def answer_draws(self, data: Mapping[str, Any]) -> list[tuple[str, str]]:
        return self._once(partial(super().answer_draws, data), "answer_draws", data)

    def _once(self, answer: Callable[[], T], *asked: object) -> T:
        key = repr(asked)
        if key not in self._outcomes:
            self._outcomes[key] = answer()
        return deepcopy(self._outcomes[key])


#: Of a trial's program, which none but an endless one comes near to: the time of the processor, whatever else it does.
SHORT_CPU_SECONDS = 0.15
#: Seeds on which a solution is graded before it is published, and changes of it that are tried besides those of whole
#: functions: a few show all that a page tells. `tests/graders/declared` tries as many changes as in service.
FEW_SEEDS, FEW_CHANGES = 2, 6


@pytest.fixture
def studio(site: Site, course_sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> Iterator[Studio]:
    limits = replace(trial_task.TRIAL_POLICY, cpu_seconds=SHORT_CPU_SECONDS)
    monkeypatch.setattr(trial_task, "TRIAL_POLICY", limits)
    monkeypatch.setattr(trial_task, "SEEDS", FEW_SEEDS)
    monkeypatch.setattr(trial, "MAX_CHANGES", FEW_CHANGES)
    monkeypatch.setattr(trial_task, "ExerciseTrial", TrialsOnce)
    course, service = the_course(), get_service(site.app, StudioService)
    grader = SandboxGrader(course, course_sandbox)

    def grade(work: GradingInput) -> Any:
        return grader.grade(work.exercise, work.source, work.seed, submission=work.submission_id)

    tasks = {
        TRIAL_JOB: DraftTrialTask(service.queue, partial(SandboxPrograms, course_sandbox)),
        TRYOUT_JOB: ProgramTryoutTask(service.queue, partial(SandboxPrograms, course_sandbox)),
        GRADE: GradingTask(course, grade),
    }
    course.exercises.find_authored = AuthoredExercises(site.database, course, clock=Ticks()).find_published
    teacher = person(site, Role.teacher, "Grace")
    yield Studio(site, teacher, teacher.browser(site), Worker(site.database, service.queue, site.settings, tasks))
    course.exercises.find_authored = lambda _: None


class Ticks:
    """A clock on which nothing is fresh any more."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 10.0
        return self.now
