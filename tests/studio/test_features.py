"""Declared exercises have what those of the course have: figures, step by step, groups of failures, hunts."""

from __future__ import annotations

import re
from dataclasses import replace
from html import unescape
from typing import Any

import pytest
from sqlalchemy import func, select
from starlette.concurrency import run_in_threadpool

from server.base.app_services import add_services, get_service
from server.behaviour.fingerprints import FINGERPRINT, FingerprintScheduler, FingerprintTask
from server.behaviour.models import BehaviourGroup, Fingerprint
from server.classes.models import ClassRole
from server.grading.sandbox_grader import SandboxPrograms
from server.hunts.protocol import HuntName, HuntQuestion, InputTrial, OfferRequest
from server.hunts.run import HuntRunner
from server.hunts.service import HuntService
from server.identity.models import Role
from server.queue.worker import Worker
from server.sandbox import Sandbox
from server.studio.models import AuthoredExercise
from server.studio.service import StudioService
from tests.graders.declared.kinds import declare
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
    FingerprintScheduler(studio.site.database, queue, course).queue_next()
    while worker.run_one():
        pass


def plain(text: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", " ", unescape(text)).replace("&nbsp;", " ").split())


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


@pytest.fixture
def hunting(studio: Studio, course_sandbox: Sandbox) -> Studio:
    """A site that asks the process of hunts, which is this one."""
    runner = HuntRunner(course_sandbox)

    async def ask(question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        asked = HuntQuestion.model_validate_json(question)
        return (await run_in_threadpool(runner.answer_question, asked)).model_dump_json().encode()

    add_services(studio.site.app, replace(get_service(studio.site.app, HuntService), ask=ask))
    return studio


def test_a_known_mistake_is_hunted_once_the_exercise_is_solved(hunting: Studio) -> None:
    mistake = {"e-0-titre": "Des carrés", "e-0-explication": "L’exposant est 2.", "e-0-programme": SQUARES}
    exercise = hunting.publish(**FORM, **mistake)
    ada = person(hunting.site, Role.student, "Ada")
    browser = ada.browser(hunting.site)
    hunt = f"/l20/exercices/{exercise.slug}/chasse"
    assert browser.get(hunt).status_code == 403
    for action in ("", "abandonner"):
        fields = {"erreur": "des_carres", "fonction": "cubes", "question": "entree", "action": action, "valeur": "3"}
        answer = browser.post(hunt, data=fields)
        assert answer.status_code == 403
        assert "L’exposant" not in answer.text
        assert "Des carrés" not in answer.text
    send(hunting, ada, exercise, CUBES)
    assert hunt in browser.get(f"/l20/exercices/{exercise.slug}").text
    page = plain(browser.get(hunt).text)
    assert "def cubes" in page, page
    assert "un entier" in page
    assert "Des carrés" not in page
    fields = {"erreur": "des_carres", "fonction": "cubes", "question": "entree"}

    def tries(typed: str) -> str:
        return plain(browser.post(hunt, data={**fields, "valeur": typed}).text)

    assert "Pas encore" in tries("2")
    assert "Attendu [0, 1] Obtenu [0, 1]" in tries("2")
    assert "doit être un entier" in tries("'a'")
    found = tries("3")
    assert "Trouvé." in found
    assert "Votre entrée est aussi petite" in found
    assert "L’exposant est 2." in found
    fields["action"] = "abandonner"
    assert "cubes(6)" in tries("")


@pytest.mark.parametrize(
    ("declaration", "wrong", "typed"),
    [
        (declare("f", "def f(t):\n    return t[::-1]\n", "f('abca')"), "def f(t):\n    return t\n", {"t": '"ab"'}),
        (
            declare("f", "def f(g, a):\n    return g(a)\n", "f(lambda x: x + 1, 2)"),
            "def f(g, a):\n    return g(0)\n",
            {"g": "lambda x: 2 * x", "a": "3"},
        ),
        (
            declare("f", "def f(a):\n    return a.sum(axis=0)\n", "f(np.array([[1.0, 2.0], [3.0, 4.0]]))"),
            "def f(a):\n    return a.sum(axis=1)\n",
            {"a": "np.array([[0.0, 1.0], [0.0, 0.0]])"},
        ),
        (declare("f", "def f(d):\n    return len(d)\n", "f({1: 2})"), "def f(d):\n    return 0\n", {"d": "{'a': 1}"}),
    ],
    ids=["text", "function", "array", "dict"],
)
def test_each_kind_of_argument_is_hunted(
    course_sandbox: Sandbox, declaration: dict[str, Any], wrong: str, typed: dict[str, str]
) -> None:
    mistake = {"id": "fausse", "titre": "Fausse", "explication": "E", "question": "", "programme": wrong}
    name = HuntName(exercise="l20/essai_222222", misconception="fausse")
    data = {name.exercise: {**declaration, "erreurs": [mistake]}}
    runner = HuntRunner(course_sandbox)
    offer = runner.answer_question(HuntQuestion(hunts=OfferRequest(hunts=(name,), seed=1), declarations=data)).offer
    assert offer is not None
    for given in (typed, {argument.name: argument.witness for argument in offer.arguments}):
        trial = InputTrial(hunt=offer.hunt, typed=given)
        outcome = runner.answer_question(HuntQuestion(hunts=trial, declarations=data)).outcome
        assert outcome is not None
        assert outcome.is_right, outcome
    for odd in ("1)", "1, 2", "f(2", "__import__('os')", "", "x", "open('a')", "[" * 99, "1 if 1 else 2", "*a", "f(1)"):
        trial = InputTrial(hunt=offer.hunt, typed=dict.fromkeys(typed, odd))
        outcome = runner.answer_question(HuntQuestion(hunts=trial, declarations=data)).outcome
        assert outcome is not None
        assert outcome.refusal
        assert not outcome.is_right
