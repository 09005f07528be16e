"""A teacher who writes exercises, and a worker that tries them in the sandbox."""

from __future__ import annotations

import re
from collections.abc import Iterator
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar
from uuid import UUID

import pytest

from graders.core.declared import trial
from server.base.app_services import get_service
from server.grading import trial_task
from server.grading.grading_task import GradingInput, GradingTask
from server.grading.sandbox_grader import SandboxGrader, SandboxPrograms
from server.grading.trial_task import TrialInput, TrialOutcome, TrialTask
from server.grading.tryout_task import TryoutTask
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


class TrialsOnce(TrialTask):
    """Tries each draft once in this process: many tests save the same form, whose trial starts a hundred programs.

    Nothing that a trial finds depends on the exercise's name, which is drawn at random.
    """

    _outcomes: ClassVar[dict[tuple[object, ...], TrialOutcome]] = {}

    def run(self, work: TrialInput) -> TrialOutcome:
        draft = repr(replace(work, exercise_id=UUID(int=0), name=""))
        key = draft, trial_task.ExerciseTrial, trial_task.TRIAL_POLICY  # a test may look at how it is tried
        if key not in self._outcomes:
            self._outcomes[key] = super().run(work)
        return deepcopy(self._outcomes[key])


#: Of a trial's program, which none but an endless one comes near to: the time of the processor, whatever else it does.
SHORT_CPU_SECONDS = 0.25
#: Seeds on which a solution is graded before it is published, and changes of it that are tried besides those of whole
#: functions: a few show all that a page tells. `tests/graders/declared` tries as many changes as in service.
FEW_SEEDS, FEW_CHANGES = 3, 12


@pytest.fixture
def studio(site: Site, course_sandbox: Sandbox, monkeypatch: pytest.MonkeyPatch) -> Iterator[Studio]:
    limits = replace(trial_task.TRIAL_POLICY, cpu_seconds=SHORT_CPU_SECONDS)
    monkeypatch.setattr(trial_task, "TRIAL_POLICY", limits)
    monkeypatch.setattr(trial_task, "SEEDS", FEW_SEEDS)
    monkeypatch.setattr(trial, "MAX_CHANGES", FEW_CHANGES)
    course, service = the_course(), get_service(site.app, StudioService)
    grader = SandboxGrader(course, course_sandbox)

    def grade(work: GradingInput) -> Any:
        return grader.grade(work.exercise, work.source, work.seed, submission=work.submission_id)

    tasks = {
        TRIAL_JOB: TrialsOnce(service.queue, partial(SandboxPrograms, course_sandbox)),
        TRYOUT_JOB: TryoutTask(service.queue, partial(SandboxPrograms, course_sandbox)),
        GRADE: GradingTask(course, grade),
    }
    course.exercises.find_authored = AuthoredExercises(site.database, course, clock=Ticks()).find
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
