"""Declared exercises have what those of the course have: figures, step by step, groups of failures, hunts."""

from __future__ import annotations

import re

from sqlalchemy import func, select

from server.base.app_services import get_service
from server.behaviour.fingerprints import FINGERPRINT, FingerprintSweeper, FingerprintTask
from server.behaviour.models import BehaviourGroup, Fingerprint
from server.classes.models import ClassRole
from server.grading.sandbox_grader import SandboxPrograms
from server.identity.models import Role
from server.queue.worker import Worker
from server.sandbox import Sandbox
from server.studio.models import AuthoredExercise
from server.studio.service import StudioService
from tests.support.classes import Person, new_class, person, seat
from tests.support.quick import the_course

from .conftest import Studio

CUBES = "def cubes(n):\n    return [k ** 3 for k in range(n)]\n"
SQUARES = "def cubes(n):\n    return [k ** 2 for k in range(n)]\n"
SQUARES_TOO = "def cubes(n):\n    r = []\n    for k in range(n):\n        r.append(k * k)\n    return r\n"
FROM_ONE = "def cubes(n):\n    return [k ** 3 for k in range(1, n + 1)]\n"
FORM = {
    "titre": "Cubes",
    "enonce": "Écrivez `cubes(n)`.",
    "solution": CUBES,
    "v-0-c-0-appel": "cubes(0)",
    "v-0-c-0-attendu": "[]",
    "v-0-c-1-appel": "cubes(6)",
    "v-0-c-1-attendu": "",
    "v-0-c-2-appel": "cubes(3)",
}


def send(studio: Studio, student: Person, exercise: AuthoredExercise, code: str) -> str:
    browser = student.browser(studio.site)
    answer = browser.post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": code})
    assert answer.status_code == 303, answer.text
    studio.work()
    return str(answer.headers["location"])


def test_a_verdict_offers_the_figure_and_the_steps_of_its_case(studio: Studio) -> None:
    exercise = studio.publish(**FORM)
    ada = person(studio.site, Role.student, "Ada")
    place = send(studio, ada, exercise, SQUARES)
    page = ada.browser(studio.site).get(place).text
    assert "/figures/v1.svg" in page
    assert "Voir pas à pas" in page or "pas à pas" in page.lower()
    assert f"{place}/pas" in page


def observe(studio: Studio, sandbox: Sandbox) -> None:
    """Carry out all observations of failed programs."""
    course, queue = the_course(), get_service(studio.site.app, StudioService).queue
    task = FingerprintTask(course, queue, lambda policy, _: SandboxPrograms(sandbox, policy))
    worker = Worker(studio.site.database, queue, studio.site.settings, {FINGERPRINT: task})
    FingerprintSweeper(studio.site.database, queue, course).sweep()
    while worker.run_one():
        pass


def plain(text: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", " ", text).replace("&nbsp;", " ").split())


def test_equal_failures_are_one_group_and_its_page_tells_them(studio: Studio, course_sandbox: Sandbox) -> None:
    exercise = studio.publish(**FORM)
    made = new_class(studio.site.database, studio.teacher.account)
    pupils = [person(studio.site, Role.student, name) for name in ("Ada", "Bob", "Eve")]
    for pupil, code in zip(pupils, (SQUARES, SQUARES_TOO, FROM_ONE), strict=True):
        seat(studio.site.database, made, pupil.account, ClassRole.student)
        send(studio, pupil, exercise, code)
    observe(studio, course_sandbox)
    with studio.site.database.read() as db:
        rows = db.execute(select(BehaviourGroup.id, func.count()).join(Fingerprint).group_by(BehaviourGroup.id)).all()
    assert sorted(count for _, count in rows) == [1, 2]
    group = next(identity for identity, count in rows if count == 2)
    page = studio.browser.get(f"/classes/{made.id}/groupes/{exercise.name}/{group}")
    assert page.status_code == 200, page.text
    text = plain(page.text)
    assert "Ada" in text
    assert "Bob" in text
    assert "Eve" not in text
    assert "Attendu 0 1 8 27 64 125 Obtenu 0 1 4 9 16 25" in text
