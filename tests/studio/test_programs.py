"""An exercise whose student writes a whole program: from the form to the verdict."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from sqlalchemy import select

from server.base.app_services import add_services, get_service
from server.identity.models import Role
from server.sandbox import Sandbox
from server.steps.questions import ProgramRunRequest, TraceQuestion
from server.steps.run import trace_question
from server.steps.service import StepService
from server.submissions.models import Submission
from tests.support.classes import person

from .conftest import Studio

FORM: dict[str, Any] = {
    "titre": "Une somme",
    "enonce": "Écrivez un programme qui lit deux entiers et affiche leur somme.",
    "solution": "a = int(input('a ? '))\nb = int(input('b ? '))\nprint('somme :', a + b)\n",
    "v-0-c-0-appel": 'programme("3", "4")',
    "v-0-c-0-attendu": "somme : 7",
    "v-0-c-1-appel": 'programme("0", "5")',
    "v-0-c-1-attendu": "a ? 0\nb ? 5\nsomme : 5",
    "v-0-c-2-appel": 'programme("-2", "9")',
    "v-0-c-2-attendu": "",
}


def test_a_program_is_written_published_and_done(studio: Studio) -> None:
    exercise = studio.publish(**FORM)
    report = studio.report(f"/mes-exercices/{exercise.id}")
    assert "x1 = entier(-2, 3); x2 = entier(4, 9) dans programme(x1, x2)" in report
    ada = person(studio.site, Role.student, "Ada")
    browser = ada.browser(studio.site)
    page = browser.get(f"/l20/exercices/{exercise.slug}").text
    assert "Programme demandé" in page
    assert "Quand on tape « 3 », puis « 4 », le programme affiche" in page.replace("\u202f", " ").replace("\xa0", " ")
    fields = page.split('id="rejouer-un-appel"')[1].split("</form>")[0]
    assert 'name="stdin"' in fields
    assert 'name="call"' not in page
    assert 'name="again"' not in page
    verdicts = []
    for code in ("print(input() + input())", "print('somme :', int(input()) + int(input()))"):
        sent = browser.post(f"/l20/exercices/{exercise.slug}/soumissions", data={"code": code})
        studio.work()
        verdicts.append(browser.get(sent.headers["location"]).text.replace("\u202f", " ").replace("\xa0", " "))
    assert "Quand on tape « 3 », puis « 4 »" in verdicts[0]
    assert "20/20" in verdicts[1].replace(" ", "")


def test_a_program_runs_with_and_without_scripts_on_what_is_typed(studio: Studio, course_sandbox: Sandbox) -> None:
    exercise = studio.publish(**FORM)
    address = f"/l20/exercices/{exercise.slug}"
    asked: list[ProgramRunRequest] = []

    async def follow(question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        read = TraceQuestion.model_validate_json(question)
        assert isinstance(read.steps, ProgramRunRequest)
        asked.append(read.steps)
        return trace_question(course_sandbox, read).model_dump_json().encode()

    add_services(studio.site.app, replace(get_service(studio.site.app, StepService), trace_program=follow))
    ada = person(studio.site, Role.student, "Ada").browser(studio.site)
    plain = ada.get(address).text.split("<noscript>")[1].split("</noscript>")[0]
    assert 'name="stdin"' in plain
    assert f'formaction="{address}/executer"' in plain
    shown = ada.post(f"{address}/executer", data={"code": FORM["solution"], "stdin": "3\r\n<b>\r\n"}).text
    assert "a ? 3\nb ? &lt;b&gt;\n" in shown
    assert "(ligne 2)" in shown, "the second line is no number"
    assert "\n3\n&lt;b&gt;\n</textarea>" in shown, "what was typed stays in the form"
    body = {"code": FORM["solution"], "call": "", "plain": True, "stdin": "3\n4"}
    trace = ada.post(f"{address}/pas", json=body).json()
    assert (trace["stdout"], trace["end"]["kind"], trace["steps"]) == ("a ? 3\nb ? 4\nsomme : 7\n", "returned", [])
    assert [request.lines for request in asked] == [("3", "<b>"), ("3", "4")]
    refused = ada.post(f"{address}/executer", data={"code": "1", "stdin": "x" * 4001}).text
    assert "au plus 4000 caractères" in refused
    assert ada.post(f"{address}/pas", json={**body, "stdin": "x" * 4001}).status_code == 422
    surrogate = b'{"code": "1", "call": "", "plain": true, "stdin": "\\ud800"}'
    answer = ada.post(f"{address}/pas", content=surrogate, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422
    with studio.site.database.read() as db:
        assert db.execute(select(Submission)).first() is None


def test_what_is_typed_alone_is_told_as_a_program(studio: Studio) -> None:
    path = studio.create()
    studio.save(path, **{**FORM, "v-0-c-0-appel": "3"})
    assert "si l’on y tape 3, puis 4, écrivez programme(" in studio.report(path)
