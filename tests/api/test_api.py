"""The HTTP interface: contract shapes, problem documents, limits, events, figures."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections import Counter
from collections.abc import Callable
from html import unescape
from itertools import pairwise
from typing import Any
from uuid import uuid4

import pytest
from fastapi import FastAPI

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.api.guide import OpenApiGuide, format_json_shape
from server.api.words import PARAMETERS, ROUTES, STATUSES
from server.base.app_services import get_service
from server.base.helpers import HelperError
from server.base.settings import Settings
from server.course import Course
from server.figures.service import FigureService
from server.grading.grading_task import GradingInput
from server.identity.models import Role
from server.queue.interfaces import WorkerCapabilities
from server.submissions.service import GRADE, OUTDATED_NOTICE, SubmissionService, worker_version_requirement
from tests.support.service import EXERCISE, Site

BODY = {"exercise": EXERCISE, "code": "pass\n"}


def problem(answer: Any, status: int) -> dict[str, Any]:
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    content: dict[str, Any] = answer.json()
    assert content["status"] == status
    assert content.keys() >= {"type", "title", "detail", "instance"}
    return content


class Drawer:
    """Draws nothing, and counts. It may be told to do something before, or to fail."""

    def __init__(self, before: Callable[[], None] = lambda: None) -> None:
        self.asked: list[dict[str, Any]] = []
        self.before = before

    async def ask(self, question: bytes) -> bytes:
        self.asked.append(json.loads(question))
        await asyncio.to_thread(self.before)
        return b"<svg/>"

    async def close(self) -> None: ...


def draws(app: FastAPI, drawer: Drawer) -> None:
    """The application has its figures drawn by this one."""
    get_service(app, FigureService).pictures._drawer = drawer


def test_exercises_are_listed_and_described(site: Site) -> None:
    headers = site.token()
    listed = site.client.get("/api/v1/exercises", headers=headers).json()
    assert EXERCISE in [one["id"] for one in listed]
    detail = site.client.get(f"/api/v1/exercises/{EXERCISE}", headers=headers).json()
    assert {one["name"] for one in detail["functions"]} == {"composer", "inverse", "relatif"}
    assert "def composer" in detail["starter"]
    assert detail["limits"]["source_bytes"] == 64 * 1024
    assert "solution" not in detail


def test_a_submission_from_sending_to_verdict(site: Site) -> None:
    headers = site.token()
    first, second = site.submit(headers), site.submit(headers, "# outcome: wrong_answer")
    assert (first["status"], first["position"], first["verdict"]) == ("queued", 1, None)
    assert second["position"] == 2
    assert first["url"] == f"/api/v1/submissions/{first['id']}"
    assert site.client.get(first["url"], headers=headers).json() == first
    while site.worker.run_one():
        pass
    done = site.client.get(second["url"], headers=headers).json()
    assert (done["status"], done["position"]) == ("done", None)
    assert done["verdict"]["outcome"] == "wrong_answer"
    assert (done["verdict"]["score"], done["verdict"]["points"]) == (0.5, 10)


def test_waiting_gives_the_verdict_or_says_that_it_is_not_there(site: Site) -> None:
    headers = site.token()
    late = site.client.post("/api/v1/submissions?wait=0.05", json=BODY, headers=headers)
    assert (late.status_code, late.json()["status"]) == (202, "queued")
    site.worker.run_one()

    def grade_later() -> None:
        while not site.worker.run_one():
            time.sleep(0.01)

    thread = threading.Thread(target=grade_later)
    thread.start()
    answer = site.client.post("/api/v1/submissions?wait=20", json=BODY, headers=headers)
    thread.join()
    assert (answer.status_code, answer.json()["verdict"]["outcome"]) == (200, "ok")


def test_the_same_code_makes_a_new_attempt_unless_the_first_will_do(site: Site) -> None:
    headers = site.token()
    first = site.submit(headers)["id"]
    assert site.submit(headers)["id"] != first
    content = {"exercise": EXERCISE, "code": "y = 2\n"}

    def reused(who: dict[str, str]) -> str:
        answer = site.client.post("/api/v1/submissions?reuse=true", json=content, headers=who)
        assert answer.status_code == 202
        return str(answer.json()["id"])

    once = reused(headers)
    assert once == reused(headers) != reused(site.token())


def test_a_name_that_is_no_text_is_an_unknown_exercise(site: Site) -> None:
    body = b'{"exercise": "\\ud800", "code": "x"}'
    headers = {**site.token(), "Content-Type": "application/json"}
    answer = site.client.post("/api/v1/submissions", content=body, headers=headers)
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"


def test_no_verdict_is_read_or_written_on_the_loop(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever else is served waits for what is done there."""
    heavy = "m" * 200_000

    def grade(sent: GradingInput) -> Judgement:
        check = CheckResult("a", "Une", False, 0, 20, heavy)
        return Judgement(Verdict(EXERCISE, "v1", Outcome.WRONG_ANSWER, sent.seed, [check]))

    where = Counter[bool]()

    def spy(module: Any, name: str) -> None:
        function = getattr(module, name)

        def spied(first: Any, *args: Any, **options: Any) -> Any:
            result = function(first, *args, **options)
            text = result if isinstance(result, str) else first
            where[_on_the_loop()] += isinstance(text, str | bytes) and len(text) >= len(heavy)
            return result

        monkeypatch.setattr(module, name, spied)

    headers = site.token()
    sent = site.submit(headers)
    spy(json, "dumps")
    spy(json, "loads")
    with site.client.stream("GET", f"{sent['url']}/events", headers=headers) as answer:
        site.worker_with(grade).run_one()
        told = "".join(answer.iter_text())
    assert heavy in told
    assert heavy in site.client.get(sent["url"], headers=headers).text
    assert where[True] == 0
    assert where[False] >= 3


def _on_the_loop() -> bool:
    """Whether this thread runs an event loop; the service's is not the main one, where Playwright keeps a loop."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return threading.current_thread() is not threading.main_thread()


def test_events_tell_each_change_and_end(site: Site) -> None:
    headers = site.token()
    site.submit(headers)
    sent = site.submit(headers)

    def grade() -> None:
        for _ in range(2):
            site.worker.run_one()

    with site.client.stream("GET", f"{sent['url']}/events", headers=headers) as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        threading.Thread(target=grade).start()
        lines = list(answer.iter_lines())
    told = [json.loads(line.removeprefix("data: ")) for line in lines if line.startswith("data: ")]
    assert {line for line in lines if line.startswith("event")} == {"event: status"}
    order = ["queued", "running", "done"]
    assert [order.index(one["status"]) for one in told] == sorted(order.index(one["status"]) for one in told)
    assert all(earlier != later for earlier, later in pairwise(told))
    assert {one["id"] for one in told} == {sent["id"]}
    assert (told[-1]["status"], told[-1]["verdict"]["outcome"]) == ("done", "ok")


def test_someone_else_s_submission_does_not_exist(site: Site) -> None:
    sent = site.submit(site.token())
    other = site.token()
    for url in (sent["url"], f"/api/v1/submissions/{uuid4()}", "/api/v1/submissions/zut"):
        for suffix in ("", "/events", "/figures/b.svg", "/figures/b.png"):
            problem(site.client.get(url + suffix, headers=other), 404)
    assert site.client.get(sent["url"], headers=site.token(Role.administrator)).status_code == 200
    problem(site.client.get(sent["url"], headers=site.token(Role.teacher)), 404)


@pytest.mark.parametrize("headers", [{}, {"Authorization": "Bearer faux"}, {"Authorization": "Basic x"}])
def test_without_a_token_nothing_is_said(site: Site, headers: dict[str, str]) -> None:
    for path in ("/exercises", f"/exercises/{EXERCISE}", f"/submissions/{uuid4()}"):
        answer = site.client.get(f"/api/v1{path}", headers=headers)
        problem(answer, 401)
        assert answer.headers["www-authenticate"].startswith("Bearer")
    for body in (BODY, {"exercise": 3}, {**BODY, "exercise": "l20/zut"}):
        problem(site.client.post("/api/v1/submissions", json=body, headers=headers), 401)
    problem(site.client.post("/api/v1/submissions?wait=zut", content="{", headers=headers), 401)


@pytest.mark.parametrize(
    ("content", "place"),
    [
        (b"{", "#"),
        (b"[]", "#"),
        (b'{"exercise": "l20/poses"}', "#/code"),
        (b'{"exercise": 1, "code": "x"}', "#/exercise"),
        (b'{"exercise": "l20/poses", "code": false}', "#/code"),
        (b'{"exercise": "l20/poses", "code": "x", "a/b": 1}', "#/a~1b"),
    ],
)
def test_refused_data_is_told_with_its_place(site: Site, content: bytes, place: str) -> None:
    headers = {**site.token(), "Content-Type": "application/json"}
    told = problem(site.client.post("/api/v1/submissions", content=content, headers=headers), 422)
    assert [one["pointer"] for one in told["errors"]] == [place]


@pytest.mark.parametrize(
    ("content", "places"),
    [
        ({"exercise": "l20/poses", "cod": "x"}, {"#/cod": "nom inconnu", "#": "valeur manquante : « code »"}),
        ({"exercice": "l20/poses", "code": "x"}, {"#/exercice": "nom inconnu", "#/exercise": "valeur manquante"}),
        (
            {"exo": "l20/poses", "file": "x"},
            {
                "#/exo": "nom inconnu",
                "#/file": "nom inconnu",
                "#/exercise": "valeur manquante",
                "#": "valeur manquante",
            },
        ),
        ({"exercise": 3}, {"#/exercise": "un texte est attendu", "#": "valeur manquante"}),
    ],
)
def test_a_name_that_is_unknown_and_the_one_that_is_missing_are_told_at_once(
    site: Site, content: dict[str, object], places: dict[str, str]
) -> None:
    told = problem(site.client.post("/api/v1/submissions", json=content, headers=site.token()), 422)
    details = {one["pointer"]: one["detail"] for one in told["errors"]}
    assert details.keys() == places.keys()
    assert all(details[place].startswith(detail) for place, detail in places.items())


@pytest.mark.parametrize("wait", ["-1", "nan", "inf", "zut"])
def test_a_wait_that_means_nothing_is_refused(site: Site, wait: str) -> None:
    told = problem(site.client.post(f"/api/v1/submissions?wait={wait}", json=BODY, headers=site.token()), 422)
    assert told["errors"][0]["parameter"] == "wait"


def test_unknown_things_are_problems(site: Site) -> None:
    headers = site.token()
    problem(site.client.get("/api/v1/exercises/l20/inconnu", headers=headers), 404)
    problem(site.client.post("/api/v1/submissions", json={**BODY, "exercise": "l20/x"}, headers=headers), 404)
    problem(site.client.get("/api/v1/classes/1/dashboard", headers=headers), 404)
    problem(site.client.get("/api/v1/nulle-part", headers=headers), 404)
    problem(site.client.delete("/api/v1/exercises", headers=headers), 405)


def test_too_large_is_told_before_and_after_parsing(site: Site, settings: Settings) -> None:
    headers = site.token()
    over = {**BODY, "code": "é" * (settings.code_bytes // 2 + 1)}
    told = problem(site.client.post("/api/v1/submissions", json=over, headers=headers), 413)["detail"]
    assert "dépasse de 2\u00a0octets la limite de 64\u00a0Kio" in told
    flood = b'{"code": "' + b"x" * settings.body_bytes
    problem(site.client.post("/api/v1/submissions", content=flood, headers=headers), 413)


def test_the_rate_limit_says_when_to_come_back(site: Site, settings: Settings) -> None:
    headers = site.token()
    for _ in range(settings.submission_burst):
        site.submit(headers)
    answer = site.client.post("/api/v1/submissions", json=BODY, headers=headers)
    problem(answer, 429)
    assert 1 <= int(answer.headers["retry-after"]) <= settings.submission_refill_seconds
    site.submit(site.token())


def test_a_heap_that_waits_says_when_to_come_back_and_costs_nothing(site: Site) -> None:
    site.tighten(waiting_each=2)
    headers = site.token()
    for _ in range(2):
        site.submit(headers)
    answer = site.client.post("/api/v1/submissions", json=BODY, headers=headers)
    assert "Vos 2 dernières propositions attendent" in problem(answer, 429)["detail"]
    assert int(answer.headers["retry-after"]) >= 1
    site.submit(site.token())
    assert site.worker.run_one()
    site.submit(headers)
    site.tighten(waiting_from_address=1)
    answer = site.client.post("/api/v1/submissions", json=BODY, headers=site.token())
    assert "depuis votre adresse" in problem(answer, 429)["detail"]
    assert "invités" not in answer.text


def test_what_nobody_takes_is_told(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    headers = site.token()
    sent = site.submit(headers)
    assert sent["notice"] is None
    monkeypatch.setattr(get_service(site.app, SubmissionService), "_is_stalled", lambda: True)
    told = site.client.get(sent["url"], headers=headers).json()
    assert told["notice"].startswith("En attente : plus rien n’est corrigé")
    assert told["position"] == 1
    assert site.worker.run_one()
    assert site.client.get(sent["url"], headers=headers).json()["notice"] is None


def test_what_waits_for_a_worker_of_its_version_is_told(site: Site) -> None:
    headers = site.token()
    sent = site.submit(headers)
    with site.database.write() as db:
        version = get_service(site.app, Course).version_of_exercise(EXERCISE)
        queue = get_service(site.app, SubmissionService)._queue
        assert not queue.mark_refused(
            db, [GRADE], WorkerCapabilities([worker_version_requirement(EXERCISE, version)], 60.0)
        ), "as the page has it"
        assert queue.mark_refused(
            db, [GRADE], WorkerCapabilities([worker_version_requirement(EXERCISE, "another")], 60.0)
        )
    assert site.client.get(sent["url"], headers=headers).json()["notice"] == OUTDATED_NOTICE
    assert site.worker.run_one(), "one machine has one version"
    assert site.client.get(sent["url"], headers=headers).json()["notice"] is None


def test_an_unexpected_failure_is_a_problem_too(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    headers = site.token()

    def broken(*_: object) -> None:
        raise RuntimeError("a secret of ours")

    monkeypatch.setattr("server.submissions.service.SubmissionService.submit", broken)
    answer = site.client.post("/api/v1/submissions", json=BODY, headers=headers)
    assert "secret" not in json.dumps(problem(answer, 500))
    page = site.client.post("/l20/exercices/poses/soumissions", data={"code": "x"})
    assert (page.status_code, "secret" in page.text) == (500, False)
    assert "<!doctype html>" in page.text.lower()


def test_figures_are_drawn_once_when_they_are_looked_at(site: Site) -> None:
    drawer = Drawer()
    draws(site.app, drawer)
    headers = site.token()
    sent = site.submit(headers)
    problem(site.client.get(f"{sent['url']}/figures/b.svg", headers=headers), 404)
    site.worker.run_one()
    assert drawer.asked == []
    for _ in range(2):
        answer = site.client.get(f"{sent['url']}/figures/b.svg", headers=headers)
        assert (answer.content, answer.headers["content-type"]) == (b"<svg/>", "image/svg+xml")
        assert answer.headers["cache-control"] == "private, no-cache"
    assert site.client.get(f"{sent['url']}/figures/b.png?theme=dark", headers=headers).status_code == 200
    asked = {"kind": "verdict", "exercise": EXERCISE, "data": {"kind": "fake"}}
    assert drawer.asked == [
        {**asked, "form": "svg", "theme": "light"},
        {**asked, "form": "png", "theme": "dark"},
    ]
    problem(site.client.get(f"{sent['url']}/figures/zut.svg", headers=headers), 404)
    problem(site.client.get(f"{sent['url']}/figures/b.svg?theme=rose", headers=headers), 422)


def test_a_figure_that_is_remembered_is_shown_to_nobody_else(site: Site) -> None:
    drawer = Drawer()
    draws(site.app, drawer)
    mine, another, teacher = site.token(), site.token(), site.token(Role.administrator)
    sent = site.submit(mine)
    site.worker.run_one()
    path = f"{sent['url']}/figures/b.svg"
    assert site.client.get(path, headers=mine).status_code == 200
    problem(site.client.get(path, headers=another), 404)
    problem(site.client.get(path), 401)
    assert site.client.get(f"/soumissions/{sent['id']}/figures/b.svg").status_code == 404
    assert site.client.get(path, headers=teacher).content == b"<svg/>"
    assert len(drawer.asked) == 1


def test_nobody_holds_a_connection_to_the_database_while_a_figure_is_drawn(site: Site) -> None:
    held: list[int] = []
    draws(site.app, Drawer(before=lambda: held.append(site.database.engine.pool.checkedout())))  # type: ignore[attr-defined]
    headers = site.token()
    sent = site.submit(headers)
    site.worker.run_one()
    assert site.client.get(f"{sent['url']}/figures/b.svg", headers=headers).status_code == 200
    assert held == [0]


def test_a_figure_that_cannot_be_drawn_is_a_problem_each_time(site: Site) -> None:
    def fail() -> None:
        raise HelperError

    drawer = Drawer(before=fail)
    draws(site.app, drawer)
    headers = site.token()
    sent = site.submit(headers)
    site.worker.run_one()
    for _ in range(2):
        answer = site.client.get(f"{sent['url']}/figures/b.svg", headers=headers)
        assert "dessinée" in problem(answer, 500)["detail"]
    assert len(drawer.asked) == 2


def test_openapi_documents_every_route_and_its_problems(site: Site) -> None:
    document = site.client.get("/api/v1/openapi.json").json()
    assert set(document["paths"]) == {
        "/api/v1/exercises", "/api/v1/exercises/{module}/{slug}", "/api/v1/submissions",
        "/api/v1/submissions/{submission_id}", "/api/v1/submissions/{submission_id}/events",
        "/api/v1/submissions/{submission_id}/figures/{name}.svg",
        "/api/v1/submissions/{submission_id}/figures/{name}.png",
        "/api/v1/submissions/{submission_id}/comments",
        "/api/v1/submissions/{submission_id}/comments/{thread_id}",
        "/api/v1/me", "/api/v1/me/export", "/api/v1/me/exercises/{module}/{slug}/last",
        "/api/v1/classes", "/api/v1/classes/join", "/api/v1/classes/{class_id}",
        "/api/v1/classes/{class_id}/roster", "/api/v1/classes/{class_id}/students",
        "/api/v1/classes/{class_id}/gradebook", "/api/v1/classes/{class_id}/audit",
        "/api/v1/classes/{class_id}/marks/{student}/{module}/{slug}",
        "/api/v1/classes/{class_id}/regrades", "/api/v1/classes/{class_id}/regrades/{regrade_id}",
        "/api/v1/classes/{class_id}/regrades/{regrade_id}/apply",
        "/api/v1/classes/{class_id}/regrades/{regrade_id}/undo",
        "/api/v1/classes/{class_id}/names/{module}/{slug}/{group}",
        "/api/v1/classes/{class_id}/dashboard", "/api/v1/classes/{class_id}/events",
        "/api/v1/classes/{class_id}/assignments", "/api/v1/classes/{class_id}/assignments/{aid}",
        "/api/v1/classes/{class_id}/assignments/{aid}/decisions/{student}",
        "/api/v1/classes/{class_id}/marking",
        "/api/v1/classes/{class_id}/columns", "/api/v1/classes/{class_id}/columns/{column_id}",
        "/api/v1/classes/{class_id}/columns/{column_id}/restore",
        "/api/v1/classes/{class_id}/columns/{column_id}/marks",
        "/api/v1/classes/{class_id}/assignments/{aid}/exceptions",
        "/api/v1/classes/{class_id}/assignments/{aid}/exceptions/{eid}",
        "/api/v1/classes/{class_id}/assignments/{aid}/rules",
    }  # fmt: skip
    text = json.dumps(document)
    named = {part.split('"')[0] for part in text.split("#/components/schemas/")[1:]}
    assert named <= document["components"]["schemas"].keys()
    for path in document["paths"].values():
        for operation in path.values():
            assert operation["summary"]
            assert operation["security"]
            for status, answer in operation["responses"].items():
                if int(status) >= 400:
                    assert "application/problem+json" in answer["content"]


def test_the_page_for_people_says_all_that_the_document_says_in_french(site: Site) -> None:
    text = unescape(site.client.get("/docs").text)
    assert 'src="http' not in text
    for path, operations in site.client.get("/api/v1/openapi.json").json()["paths"].items():
        assert f"</span> {path}</code>" in text
        for method, operation in operations.items():
            assert (method, path) in ROUTES, "server/api/words.py says each route in French"
            assert {one["name"] for one in operation.get("parameters", ())} <= PARAMETERS.keys()
            assert operation["responses"].keys() <= STATUSES.keys()
    assert '"status": "queued" | "running" | "done"' in text
    assert "http://testserver/api/v1/submissions/$ID/figures/$FIGURE.svg" in text
    assert "bearer" in text.lower()


def test_the_shapes_of_answers_are_those_of_the_schemas() -> None:
    inner = {"type": "object", "properties": {"n": {"type": "integer"}, "any": {}}}
    schemas = {"Inner": inner, "Again": {"type": "object", "properties": {"more": {"$ref": "#/c/s/Again"}}}}
    guide = OpenApiGuide({"components": {"schemas": schemas}}, "l20/poses", "")
    several = {"type": "array", "items": {"$ref": "#/c/s/Inner"}}
    maybe = {"anyOf": [{"$ref": "#/c/s/Inner"}, {"type": "null"}]}
    spelt = '{\n  "n": entier,\n  "any": valeur JSON\n}'
    assert (format_json_shape(guide, several), format_json_shape(guide, maybe)) == (f"[{spelt}, …]", f"{spelt} | null")
    assert format_json_shape(guide, {"$ref": "#/c/s/Again"}).count("more") == 4, "a schema that holds itself ends"
