"""Answers without code: over the API, in the store, from one account to another; on both databases."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from string import ascii_lowercase
from typing import Any

import pytest
from sqlalchemy import select

from graders.core.answers.numeric import NumericGrader
from graders.core.contract.findings import Judgement
from server.course import Course
from server.database import Database
from server.gradebook import service as gradebook
from server.grading.grading_task import GradingInput
from server.grading.sandbox_grader import SandboxGrader
from server.identity import repository as identity
from server.identity.models import Account, Role
from server.queue.worker import Worker
from server.sandbox import Sandbox
from server.submissions import variants
from server.submissions.models import Submission, Variant
from server.submissions.service import SubmissionService
from tests.support.quick import some
from tests.support.service import ADDRESS, EXERCISE, Site, new_account

ODOMETRY, QUIZ, PROOF = (f"l20/{slug}" for slug in ("calcul_odometrie", "verification", "demo_1"))
PAGE = "/l20/exercices/calcul_odometrie"
SEND = "/api/v1/submissions"
FORM = {"name": "Ada L.", "login": "ada@example.org", "password": "une phrase assez longue"}


@pytest.fixture
def grading(site: Site, course: Course, course_sandbox: Sandbox) -> Worker:
    """A worker that grades in earnest; answers never reach the sandbox."""
    grader = SandboxGrader(course, course_sandbox)

    def grade(sent: GradingInput) -> Judgement:
        return grader.grade(sent.exercise, sent.source, sent.seed)

    return site.worker_with(grade)


def stored(database: Database, row: Any) -> list[Any]:
    with database.read() as db:
        return list(db.execute(select(row)).scalars())


def detail(site: Site, headers: dict[str, str], name: str = ODOMETRY) -> dict[str, Any]:
    answer = site.client.get(f"/api/v1/exercises/{name}", headers=headers)
    assert answer.status_code == 200
    found: dict[str, Any] = answer.json()
    return found


def send(site: Site, headers: dict[str, str], answers: Any, name: str = ODOMETRY) -> dict[str, Any]:
    answer = site.client.post(SEND, json={"exercise": name, "answers": answers}, headers=headers)
    assert answer.status_code == 202, answer.text
    sent: dict[str, Any] = answer.json()
    return sent


@pytest.mark.parametrize("name", [ODOMETRY, QUIZ, PROOF])
def test_from_the_questions_to_the_verdict(site: Site, grading: Worker, course: Course, name: str) -> None:
    headers = site.token()
    shown = detail(site, headers, name)
    assert shown["kind"] == "answers"
    (deal,) = stored(site.database, Variant)
    exercise = course.exercises[name]
    assert exercise.answers is not None
    right = dict(exercise.answers.right_answers(deal.seed))
    assert set(right) == {one["id"] for one in shown["questions"]}
    good, blank = send(site, headers, right, name), send(site, headers, {}, name)
    while grading.run_one():
        pass
    done = [site.client.get(one["url"], headers=headers).json()["verdict"] for one in (good, blank)]
    assert [one["outcome"] for one in done] == ["ok", "invalid_output"]
    assert {one["seed"] for one in done} == {deal.seed}
    assert detail(site, headers, name) == shown


def test_a_row_alone_is_what_is_graded(site: Site, course: Course) -> None:
    headers = site.token()
    sent = send(site, headers, {"dtheta": "0,1", "ds": 1})
    (row,) = stored(site.database, Submission)
    (deal,) = stored(site.database, Variant)
    assert str(row.id) == sent["id"]
    assert (row.source, row.seed) == (b'{"ds":1,"dtheta":"0,1"}', deal.seed)
    other = send(site, headers, {"ds": 1, "dtheta": "0,1"})
    same = next(one for one in stored(site.database, Submission) if str(one.id) == other["id"])
    assert same.digest == row.digest, "the order of the questions makes no new attempt"


def test_exercises_of_code_are_listed_as_such(site: Site) -> None:
    headers = site.token()
    kinds = {one["id"]: one["kind"] for one in site.client.get("/api/v1/exercises", headers=headers).json()}
    assert (kinds[EXERCISE], kinds[ODOMETRY]) == ("code", "answers")
    shown = detail(site, headers, EXERCISE)
    assert (shown["questions"], shown["given"]) == ([], [])
    assert stored(site.database, Variant) == []


@pytest.mark.parametrize(
    ("name", "body", "places"),
    [
        (ODOMETRY, {}, {"#/answers"}),
        (ODOMETRY, {"code": "x"}, {"#/answers", "#/code"}),
        (ODOMETRY, {"code": "x", "answers": {}}, {"#/code"}),
        (EXERCISE, {"answers": {}}, {"#/code", "#/answers"}),
        (EXERCISE, {"code": "x", "answers": {}}, {"#/answers"}),
        (ODOMETRY, {"answers": []}, {"#/answers"}),
        (ODOMETRY, {"answers": None}, {"#/answers"}),
        (ODOMETRY, {"answers": "ds"}, {"#/answers"}),
    ],
)
def test_exactly_what_the_exercise_asks_for(site: Site, name: str, body: dict[str, Any], places: set[str]) -> None:
    answer = site.client.post(SEND, json={"exercise": name, **body}, headers=site.token())
    assert (answer.status_code, answer.headers["content-type"]) == (422, "application/problem+json")
    assert {one["pointer"] for one in answer.json()["errors"]} == places
    assert stored(site.database, Submission) == []


@pytest.mark.parametrize(
    ("value", "status"),
    [
        (b'"\\ud800"', 422),
        (b'"' + b"x" * 70_000 + b'"', 413),
        (b"[" * 5_000 + b"]" * 5_000, 400),
        (b"NaN", 202),
        (b"1e999", 202),
        (b"[" * 300 + b"]" * 300, 202),
        (b'"\\u0000"', 202),
        (b"1" * 4_000, 202),
        (b"1" * 9_000, 400),
    ],
)
def test_hostile_values_are_refused_or_judged(site: Site, grading: Worker, value: bytes, status: int) -> None:
    body = b'{"exercise": "l20/calcul_odometrie", "answers": {"ds": ' + value + b"}}"
    headers = {**site.token(), "Content-Type": "application/json"}
    answer = site.client.post(SEND, content=body, headers=headers)
    assert answer.status_code == status, answer.text
    if status == 202:
        grading.run_one()
        verdict = site.client.get(answer.json()["url"], headers=headers).json()["verdict"]
        assert verdict["outcome"] == "invalid_output"


def test_a_deal_is_made_once_whoever_asks_first(database: Database, store: SubmissionService, ada: Account) -> None:
    with ThreadPoolExecutor(4) as pool:
        seeds = set(pool.map(lambda _: variants.ensure_seed(database, ada, ODOMETRY), range(12)))
    assert len(seeds) == 1
    with database.write() as db:
        sent = store.submit_answers(db, ada, ODOMETRY, {"ds": 1}, address=ADDRESS)
        assert {sent.seed} == seeds
    assert variants.ensure_seed(database, ada, QUIZ) not in seeds
    assert variants.ensure_seed(database, new_account(database), ODOMETRY) not in seeds


def test_a_guest_s_deals_follow_and_an_account_keeps_its_own(
    database: Database, store: SubmissionService, ada: Account
) -> None:
    guest = new_account(database, Role.guest)
    mine = variants.ensure_seed(database, ada, ODOMETRY)
    theirs = {name: variants.ensure_seed(database, guest, name) for name in (ODOMETRY, QUIZ)}
    with database.write() as db:
        store.submit_answers(db, guest, ODOMETRY, {"ds": 1}, address=ADDRESS)
        gradebook.move_guest_attempts(db, guest.id, ada.id)
        identity.delete_account(db, guest.id)
    assert variants.ensure_seed(database, ada, ODOMETRY) == mine != theirs[ODOMETRY]
    assert variants.ensure_seed(database, ada, QUIZ) == theirs[QUIZ]
    assert [one.account_id for one in stored(database, Variant)] == [ada.id, ada.id]
    (sent,) = stored(database, Submission)
    assert (sent.account_id, sent.seed) == (ada.id, theirs[ODOMETRY]), "an attempt keeps the deal that it answers"


def test_a_visitor_keeps_the_numbers_through_sign_up_and_log_in(site: Site) -> None:
    numbers = re.compile(r'class="given-value">([^<]*)')
    first = site.client.get(PAGE)
    assert first.status_code == 200
    seen = numbers.findall(first.text)
    assert len(seen) == 8
    site.client.post("/inscription", data=FORM)
    assert numbers.findall(site.client.get(PAGE).text) == seen
    site.client.post("/deconnexion")
    assert numbers.findall(site.client.get(PAGE).text) != seen
    site.client.post("/connexion", data={"login": FORM["login"], "password": FORM["password"]})
    assert numbers.findall(site.client.get(PAGE).text) == seen
    assert len(stored(site.database, Variant)) == 1


def test_reading_an_exercise_of_code_makes_no_guest(site: Site) -> None:
    site.client.get("/l20/exercices/poses")
    assert stored(site.database, Account) == []


def test_our_own_failure_is_an_internal_error(site: Site, grading: Worker, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("a formula of ours")

    monkeypatch.setattr(NumericGrader, "judge", fail)
    headers = site.token()
    sent = send(site, headers, {"ds": 1})
    grading.run_one()
    verdict = site.client.get(sent["url"], headers=headers).json()["verdict"]
    assert (verdict["outcome"], verdict["checks"]) == ("internal_error", [])


def test_variant_is_visible_to_its_account_only(site: Site) -> None:
    one, other = site.token(), site.token()
    assert detail(site, one)["given"] != detail(site, other)["given"]
    assert site.client.get(send(site, one, {"ds": 1})["url"], headers=other).status_code == 404


def test_the_exercise_tells_no_secret(site: Site) -> None:
    headers = site.token()
    for name in (QUIZ, PROOF):
        for question in some(detail(site, headers, name)["questions"]):
            assert question.keys() == {"id", "title", "text_html", "form", "points", "unit", "pieces"}
            assert [one["id"] for one in question["pieces"]] == list(ascii_lowercase[: len(question["pieces"])])
            assert all(one.keys() == {"id", "text_html"} for one in question["pieces"])
