"""The addresses of what is followed: who may, of what, how often, and what is asked of the process that does it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from sqlalchemy import select

from graders.core.contract.findings import Judgement
from graders.core.contract.local import LOCAL
from graders.core.contract.verdict import Verdict
from server.assignments import sittings
from server.assignments.models import Mode
from server.base.app_services import add_services, get_service
from server.base.errors import InternalFailure, Overloaded
from server.course import Course
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import GradingResult
from server.identity.models import Role
from server.sandbox import Sandbox
from server.steps.questions import CallTraceRequest, CellTraceRequest, ReplayTraceRequest, TraceQuestion
from server.steps.run import trace_question
from server.steps.schemas import EndOut, NumberOut, TraceOut
from server.steps.service import StepService
from server.submissions.models import Submission
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.service import Site

POSES = "l20/poses"
JSON = {"Accept": "application/json"}
CODE = "def composer(a, b):\n    return a[0] + b[0]\n"


@dataclass
class Process:
    """Follows nothing, and keeps what it was asked."""

    raises: Exception | None = None
    asked: list[Any] = field(default_factory=list)

    async def __call__(self, question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        self.asked.append(TraceQuestion.model_validate_json(question).steps)
        if self.raises:
            raise self.raises
        return b'{"steps": []}'


def follow(site: Site, process: Process, **limits: float) -> Process:
    steps = get_service(site.app, StepService)
    settings = steps.settings.model_copy(update=limits)
    add_services(site.app, replace(steps, trace_program=process, settings=settings))
    return process


@pytest.fixture
def process(site: Site) -> Process:
    return follow(site, Process())


@pytest.fixture(scope="module")
def failed(course: Course) -> tuple[bytes, Verdict]:
    """A program that makes a mistake, and its verdict."""
    exercise = course.exercises[POSES]
    source = exercise.solution.replace("ramener(ta + tb)", "ta + tb").encode()
    return source, exercise.grader.grade(source, LOCAL, seed=5, version=exercise.version).verdict


def sent(site: Site, who: Person, failed: tuple[bytes, Verdict]) -> str:
    """The name of an attempt of theirs, graded."""
    source, verdict = failed
    with site.database.write() as db:
        row = Submission(account_id=who.id, exercise=POSES, source=source, digest="d", seed=verdict.seed)
        db.add(row)
        db.flush()
        gradebook.record_grading(db, row.id, GradingResult(Judgement(verdict), utc_now()))
        return str(row.id)


def test_a_visitor_has_a_cell_followed(site: Site, process: Process) -> None:
    answer = site.client.post("/l20/cellules/pas", json={"code": "x = 1\r\n"})
    assert (answer.status_code, answer.json()) == (200, {"steps": []})
    assert answer.headers["cache-control"] == "no-store"
    assert process.asked == [CellTraceRequest(module="l20", code="x = 1\n")]
    assert site.client.post("/l99/cellules/pas", json={"code": ""}).status_code == 404
    long = "#" * (site.settings.code_bytes + 1)
    assert site.client.post("/l20/cellules/pas", json={"code": long}).status_code == 413


def test_ones_own_call_goes_with_what_the_program_may_import(site: Site, process: Process, course: Course) -> None:
    exercise = next(one for one in course.exercises.values() if POSES.split("/")[1] in one.reuses)
    address = f"/{exercise.id.replace('/', '/exercices/')}/pas"
    answer = site.client.post(address, json={"code": "from mes_fonctions import composer\n", "call": "f(1, (2, pi))"})
    assert answer.status_code == 200, answer.text
    (asked,) = process.asked
    assert isinstance(asked, CallTraceRequest)
    assert (asked.exercise, asked.call) == (exercise.id, "f(1, (2, pi))")
    assert {one.label: one.sealed for one in asked.library}["poses"] is True


def test_a_program_is_run_plainly_with_a_call_or_as_it_is(site: Site, process: Process) -> None:
    for call in ("composer((0, 0, 0), (1, 0, 0))", " "):
        body = {"code": CODE, "call": call, "plain": True}
        assert site.client.post("/l20/exercices/poses/pas", json=body).status_code == 200
        assert (process.asked[-1].call, process.asked[-1].plain) == (call, True)
    for call, plain in (("composer(x)", True), ("", False)):
        body = {"code": CODE, "call": call, "plain": plain}
        assert site.client.post("/l20/exercices/poses/pas", json=body, headers=JSON).status_code == 422
    assert len(process.asked) == 2


@pytest.mark.parametrize(
    ("slug", "call", "status"),
    [
        ("poses", "composer(x)", 422),
        ("poses", "f" * 5000, 422),
        ("nulle_part", "f()", 404),
        ("verification", "f()", 404),
    ],
)
def test_a_call_that_cannot_be_made_costs_nothing(
    site: Site, process: Process, slug: str, call: str, status: int
) -> None:
    follow(site, process, step_burst=1, step_refill_seconds=1000)
    for _ in range(3):
        answer = site.client.post(f"/l20/exercices/{slug}/pas", json={"code": CODE, "call": call}, headers=JSON)
        assert answer.status_code == status
    assert process.asked == []


def test_the_case_of_a_failed_check_is_asked_as_the_verdict_shows_it(
    site: Site, process: Process, failed: tuple[bytes, Verdict]
) -> None:
    ada = person(site)
    name = sent(site, ada, failed)
    check = next(one for one in failed[1].checks if one.id == "composer_tours")
    answer = ada.browser(site).post(f"/soumissions/{name}/pas", json={"check": check.id})
    assert answer.status_code == 200, answer.text
    (asked,) = process.asked
    assert isinstance(asked, ReplayTraceRequest)
    assert check.counterexample is not None
    assert (asked.source, asked.inputs, asked.seed) == (failed[0], check.counterexample.inputs, 5)
    assert asked.mistakes == ("angle_jamais_ramene",)
    assert asked.policy == get_service(site.app, Course).exercises[POSES].policy


def test_whoever_may_read_an_attempt_may_follow_it_and_nobody_else(
    site: Site, process: Process, failed: tuple[bytes, Verdict]
) -> None:
    ada, teacher, stranger = person(site), person(site, Role.teacher), person(site)
    made = new_class(site.database, teacher.account)
    seat(site.database, made, ada.account)
    address = f"/soumissions/{sent(site, ada, failed)}/pas"
    body = {"check": "composer_tours"}
    assert teacher.browser(site).post(address, json=body).status_code == 200
    assert stranger.browser(site).post(address, json=body, headers=JSON).status_code == 404
    assert site.client.post(address, json=body, headers=JSON).status_code == 404
    assert len(process.asked) == 1


@pytest.mark.parametrize("check", ["identites", "composer_exemples", "rien", ""])
def test_a_check_that_shows_no_call_is_refused(
    site: Site, process: Process, failed: tuple[bytes, Verdict], check: str
) -> None:
    """Of several functions, passed, unknown."""
    ada = person(site)
    answer = ada.browser(site).post(f"/soumissions/{sent(site, ada, failed)}/pas", json={"check": check}, headers=JSON)
    assert (answer.status_code, process.asked) == (422, [])


def test_a_test_holds_back_its_exercise_but_for_who_teaches(
    site: Site, process: Process, failed: tuple[bytes, Verdict]
) -> None:
    ada, teacher = person(site), person(site, Role.teacher)
    made = new_class(site.database, teacher.account)
    seat(site.database, made, ada.account)
    assign(site.database, made, POSES, mode=Mode.test)
    name = sent(site, ada, failed)
    browser, body = ada.browser(site), {"code": CODE, "call": "composer((1,), (2,))"}
    refused = browser.post("/l20/exercices/poses/pas", json=body, headers=JSON)
    assert (refused.status_code, "Interro" in refused.json()["detail"]) == (409, True)
    held = browser.post(f"/soumissions/{name}/pas", json={"check": "composer_tours"}, headers=JSON)
    assert (held.status_code, process.asked) == (422, [])
    assert browser.post("/l20/exercices/odometrie/pas", json=body).status_code == 200
    assert teacher.browser(site).post(f"/soumissions/{name}/pas", json={"check": "composer_tours"}).status_code == 200


def test_what_a_running_test_asks_for_is_not_imported_elsewhere_to_compare_one_s_own_with(
    site: Site, process: Process
) -> None:
    ada, made = person(site), new_class(site.database, person(site, Role.teacher).account)
    seat(site.database, made, ada.account)
    test = assign(site.database, made, POSES, mode=Mode.test)
    browser, imports = ada.browser(site), "from mes_fonctions import composer\n"

    def statuses(code: str) -> list[int]:
        followed = browser.post("/l20/exercices/metriques/pas", json={"code": code, "call": "ate(1, 2)"})
        body = {"exercise": "l20/metriques", "code": code}
        sent = site.client.post("/api/v1/submissions", json=body, headers=ada.headers)
        return [followed.status_code, sent.status_code]

    assert statuses(imports) == [200, 202]
    with site.database.write() as db:
        sittings.begin_sitting(db, test, ada.id, (), utc_now())
    assert (statuses(imports), statuses(CODE)) == ([409, 409], [200, 202])


@pytest.mark.parametrize(
    ("raises", "status"), [(Overloaded("Attendez.", retry_after=2), 503), (InternalFailure("Incident."), 500)]
)
def test_what_was_not_followed_costs_nothing(site: Site, raises: Exception, status: int) -> None:
    process = follow(site, Process(raises), step_burst=1, step_refill_seconds=1000)
    ada = person(site).browser(site)
    for _ in range(2):
        answer = ada.post("/l20/cellules/pas", json={"code": "1"}, headers=JSON)
        assert answer.status_code == status, answer.text
    process.raises = None
    assert ada.post("/l20/cellules/pas", json={"code": "1"}).status_code == 200
    assert ada.post("/l20/cellules/pas", json={"code": "1"}, headers=JSON).status_code == 429


def test_a_call_runs_without_scripts_and_is_no_attempt(site: Site) -> None:
    @dataclass
    class Runner(Process):
        async def __call__(self, question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
            await super().__call__(question, reader=reader, flow=flow, rank=rank)
            end = EndOut(kind="returned", value=NumberOut(type="int", text="42"))
            return (
                TraceOut(
                    lines=[], filename="f", call="f()", frames=[], steps=[], end=end, left_out=[], stdout="avant <b>\n",
                    mark=None, milliseconds=1,
                ).model_dump_json().encode()
            )  # fmt: skip

    process = follow(site, Runner())
    exercise = site.client.get("/l20/exercices/poses").text
    assert 'formaction="/l20/exercices/poses/executer"' in exercise.split("<noscript>")[1].split("</noscript>")[0]
    form = {"code": CODE, "call": "composer([1], [2])"}
    page = site.client.post("/l20/exercices/poses/executer", data=form).text
    assert "avant &lt;b&gt;" in page
    assert "42" in page
    assert 'class="form own-run"' in page, "its fields have the page's width"
    assert CODE.replace("\n", "") in page.replace("\n", ""), "the code stays in the form"
    assert isinstance(process.asked[0], CallTraceRequest)
    assert process.asked[0].plain
    refused = site.client.post("/l20/exercices/poses/executer", data=form | {"call": "composer([1"}).text
    assert 'role="alert"' in refused
    assert len(process.asked) == 1
    with site.database.read() as db:
        assert db.execute(select(Submission)).first() is None


def test_a_small_program_uses_the_class_that_an_exercise_asks_for(site: Site, course_sandbox: Sandbox) -> None:
    address = "/l20/exercices/noeud_ros"
    page = site.client.get(address).text
    fields = page.split('id="rejouer-un-appel"')[1].split("</form>")[0]
    assert 'name="after"' in fields
    assert 'name="call"' not in page
    assert 'name="after"' in page.split("<noscript>")[1].split("</noscript>")[0]

    async def run(question: bytes, *, reader: str, flow: str, rank: int = 0) -> bytes:
        return trace_question(course_sandbox, TraceQuestion.model_validate_json(question)).model_dump_json().encode()

    add_services(site.app, replace(get_service(site.app, StepService), trace_program=run))
    code = "class ArretUrgence:\n    def __init__(self, d):\n        self.d = 1 / d\n"

    def played(after: str) -> tuple[str, str, int | None]:
        body = {"code": code, "call": "", "plain": True, "after": after}
        trace = site.client.post(f"{address}/pas", json=body).json()
        return trace["stdout"], trace["end"]["title"], trace["end"]["line"]

    assert played("a = ArretUrgence(4)\na.d") == ("0.25\n", "", None)
    assert played("print(H)\nabsent") == ("16\n", "Erreur à l’exécution, ligne 2 du petit programme", None)
    assert played("ArretUrgence(0)")[2] == 3, "a fault of the file is told by its own line"
    form = {"code": code, "after": "ArretUrgence(2).d\r\n"}
    shown = site.client.post(f"{address}/executer", data=form).text
    assert "0.5\n" in shown
    assert "ArretUrgence(2).d\n</textarea>" in shown
    assert "au plus 4000 caractères" in site.client.post(f"{address}/executer", data=form | {"after": "x" * 4001}).text
    with site.database.read() as db:
        assert db.execute(select(Submission)).first() is None
