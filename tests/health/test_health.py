"""Whether the service is alive and ready, its figures, and the trail from a request to its verdict in the logs."""

from __future__ import annotations

import io
import json
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from datetime import timedelta
from typing import Any
from uuid import uuid4

import pytest
from prometheus_client.parser import text_string_to_metric_families
from sqlalchemy import select, text, update
from sqlalchemy.exc import OperationalError
from sqlalchemy.orm import Session

from server.base import logs
from server.base.app_services import add_services, get_service
from server.base.counters import TEMPLATE_RENEWALS
from server.base.logs import JsonLines
from server.base.middleware import RequestLogMiddleware
from server.base.version import VERSION
from server.database import utc_now
from server.grading.supervisor import WorkerSupervisor
from server.health import readiness as checks
from server.health import repository
from server.health.event_counter import TemplateRenewalCounter
from server.health.metrics import PrometheusMetrics
from server.health.readiness import ReadinessChecks
from server.queue.models import Job
from server.queue.wakeups import WakeupDispatcher
from tests.support.client import TestClient
from tests.support.service import EXERCISE, Site

TOKEN = "un secret de Prometheus"
FORM = {"name": "Ada", "login": "ada", "password": "notes sur la machine"}


@pytest.fixture(autouse=True)
def _room_on_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "free_bytes", lambda _folder: 10**12)


def test_alive_asks_nothing_and_ready_says_what_is_amiss(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    assert site.client.get("/healthz").json() == {"status": "ok", "version": VERSION}
    ready = site.client.get("/readyz")
    assert (ready.status_code, ready.json()["status"]) == (200, "ok")
    assert "set-cookie" not in ready.headers, "who asks is no visitor"
    with monkeypatch.context() as broken:
        broken.setattr(repository, "ping_database", _fails)
        amiss = site.client.get("/readyz")
        assert (amiss.status_code, amiss.json()["checks"]["database"]) == (503, "unreachable")
        assert site.client.get("/healthz").status_code == 200
    supervisor = get_service(site.app, WorkerSupervisor)
    monkeypatch.setattr(WorkerSupervisor, "target_worker_count", 2)
    assert site.client.get("/readyz").json()["checks"]["workers"] == "none"
    monkeypatch.setattr(supervisor, "alive_worker_count", lambda: 1)
    assert site.client.get("/readyz").status_code == 200
    supervisor.stop_restarting_workers()
    assert site.client.get("/readyz").json()["checks"]["service"] == "stopping"


def test_without_what_carries_the_work_it_serves_and_says_so(site: Site) -> None:
    assert "nats" not in site.client.get("/readyz").json()["checks"], "one machine has none"
    readiness = get_service(site.app, ReadinessChecks)
    for state, status in (("unreachable", "degraded"), ("ok", "ok")):
        add_services(site.app, replace(readiness, broker_status=lambda state=state: state))
        answer = site.client.get("/readyz")
        assert (answer.status_code, answer.json()["status"], answer.json()["checks"]["nats"]) == (200, status, state)


def test_little_room_on_the_disk_is_told_and_stops_nobody(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "free_bytes", lambda _folder: 1)
    answer = site.client.get("/readyz")
    assert (answer.status_code, answer.json()["status"]) == (200, "degraded")
    assert answer.json()["checks"]["disk"] == "nearly full"


def test_where_other_machines_grade_and_none_does_it_is_not_ready(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not get_service(site.app, WorkerSupervisor).target_worker_count, "none is set here"
    site.submit(site.token())
    assert site.client.get("/readyz").status_code == 200, "it has only just come"
    monkeypatch.setattr(checks, "NOBODY_GRADES_AFTER", -timedelta(seconds=1))
    answer = site.client.get("/readyz")
    assert (answer.status_code, answer.json()["checks"]["workers"]) == (503, "none")
    with site.database.write() as db:
        db.execute(update(Job).values(lease_token=uuid4(), lease_until=utc_now()))
    assert site.client.get("/readyz").status_code == 200, "somebody grades"


def _fails(_db: Session) -> None:
    raise OperationalError("SELECT 1", {}, Exception("gone"))


@pytest.fixture
def measured(site: Site) -> Any:
    """Reads the metrics: by name and labels, what each is."""
    site.tighten(metrics_token=TOKEN)

    def read(token: str = TOKEN) -> dict[tuple[str, frozenset[tuple[str, str]]], float]:
        answer = site.client.get("/metrics", headers={"Authorization": f"Bearer {token}"})
        assert answer.status_code == 200, answer.text
        families = text_string_to_metric_families(answer.text)
        return {(one.name, frozenset(one.labels.items())): one.value for family in families for one in family.samples}

    return read


def test_metrics_are_for_who_shows_the_token(site: Site) -> None:
    assert site.client.get("/metrics", headers={"Authorization": "Bearer "}).status_code == 404, "none is set"
    site.tighten(metrics_token=TOKEN)
    for shown in ("", "Bearer", "Bearer autre", f"Basic {TOKEN}", f"Bearer {TOKEN}x"):
        assert site.client.get("/metrics", headers={"Authorization": shown}).status_code == 401


def test_metrics_tell_what_waits_and_each_first_verdict_once(site: Site, measured: Any) -> None:
    headers = site.token()
    site.submit(headers)
    site.submit(headers, "outcome: wrong_answer")
    waiting = frozenset({("kind", "grade"), ("state", "waiting")})
    before = measured()
    assert before["balise_queue_jobs", waiting] == 2
    assert before["balise_queue_oldest_seconds", frozenset({("kind", "grade")})] >= 0
    while site.worker.run_one():
        pass
    for _ in range(2):
        after = measured()
        assert ("balise_queue_jobs", waiting) not in after
        for outcome in ("ok", "wrong_answer"):
            labels = frozenset({("exercise", EXERCISE), ("outcome", outcome)})
            for name in ("balise_verdict_seconds", "balise_grading_seconds"):
                assert after[f"{name}_count", labels] == 1
            assert after["balise_verdict_seconds_sum", labels] >= after["balise_grading_seconds_sum", labels] >= 0


def test_metrics_count_what_is_refused_and_what_is_renewed(site: Site, measured: Any) -> None:
    def refused(why: str) -> float:
        return float(measured().get(("balise_refused_logins_total", frozenset({("why", why)})), 0))

    before = {why: refused(why) for why in ("password", "token", "too_many")}
    site.client.post("/connexion", data={"login": "ada", "password": "au hasard"})
    site.client.get("/api/v1/exercises", headers={"Authorization": "Bearer balise_zut"})
    site.tighten(metrics_token=TOKEN, login_burst=1, login_refill_seconds=1000)
    for _ in range(2):
        site.client.post("/connexion", data={"login": "eve", "password": "au hasard"})
    assert {why: refused(why) - before[why] for why in before} == {"password": 2, "token": 1, "too_many": 1}
    known = TEMPLATE_RENEWALS.counts().get("worn", 0)
    WakeupDispatcher(lambda _key: None).handle_message(_Nowhere(), "renewed worn")
    assert measured()["balise_template_renewals_total", frozenset({("why", "worn")})] == known + 1
    elsewhere = TemplateRenewalCounter(site.database)
    for _ in range(2):
        elsewhere.count_template_renewal("worn")
    assert measured()["balise_template_renewals_total", frozenset({("why", "worn")})] == known + 3
    get_service(site.app, PrometheusMetrics).set_wall_states({"seccomp": True, "cgroup": False})
    walls = {labels: value for (name, labels), value in measured().items() if name == "balise_wall_standing"}
    assert walls == {frozenset({("wall", "seccomp")}): 1, frozenset({("wall", "cgroup")}): 0}


class _Nowhere:
    def write(self, data: bytes) -> None:
        raise AssertionError("nobody is woken")


@contextmanager
def told() -> Iterator[io.StringIO]:
    """What the logs say in JSON, of all that is ours."""
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.setFormatter(JsonLines("test"))
    root, level = logging.getLogger(), logs.event_log.level
    root.addHandler(handler)
    logs.event_log.setLevel(logging.INFO)
    try:
        yield stream
    finally:
        root.removeHandler(handler)
        logs.event_log.setLevel(level)


def test_the_logs_follow_a_request_to_its_verdict_and_tell_nothing_of_its_author(site: Site) -> None:
    secret = "x_secret = 'mon adresse'"
    with told() as stream:
        answer = site.client.post("/l20/exercices/poses/soumissions", data={"code": secret})
        site.worker.run_one()
        site.client.get("/bienvenue/jeton-secret")
    lines = [json.loads(line) for line in stream.getvalue().splitlines()]
    request = answer.headers["x-request-id"]
    mine = [line["message"] for line in lines if line.get("request") == request]
    assert mine == ["request", "verdict", "job done"]
    verdict = next(line for line in lines if line["message"] == "verdict")
    assert (verdict["exercise"], verdict["outcome"]) == (EXERCISE, "ok")
    asked = [line["route"] for line in lines if line["message"] == "request"]
    assert asked == ["/{module:module}/exercices/{slug}/soumissions", "/bienvenue/{token}"]
    with site.database.read() as db:
        assert db.execute(select(Job)).first() is None
    for hidden in ("x_secret", "adresse", "jeton-secret", "testclient", "127.0.0.1"):
        assert hidden not in stream.getvalue()


def test_an_error_is_logged_with_its_trace_and_without_what_a_statement_carries(site: Site) -> None:
    carried = {"key": "du code d’élève"}
    with told() as stream, site.database.read() as db:
        try:
            db.execute(text("SELECT nowhere FROM job WHERE key = :key"), carried)
        except OperationalError:
            logging.getLogger("server.test").exception("failed")
    (line,) = [json.loads(one) for one in stream.getvalue().splitlines()]
    assert "Traceback" in line["exception"]
    assert "nowhere" in line["exception"]
    assert "code d’élève" not in stream.getvalue()


@pytest.mark.parametrize(
    ("proxied", "given", "kept"),
    [
        (True, "abc-DEF.12", True),
        (True, "court", False),
        (True, "a b\r\nSet-Cookie", False),
        (False, "abc-DEF.12", False),
    ],
)
def test_a_trusted_proxy_names_requests_and_nobody_else(proxied: bool, given: str, kept: bool) -> None:
    async def app(scope: Any, receive: Any, send: Any) -> None:
        assert logs.current_request_id()
        await send({"type": "http.response.start", "status": 204, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    headers = {"X-Request-ID": given.replace("\r\n", " ")}
    name = TestClient(RequestLogMiddleware(app, proxied)).get("/", headers=headers).headers["x-request-id"]
    assert (name == given) is kept
    assert logs.REQUEST_ID_PATTERN.fullmatch(name)
    assert not logs.current_request_id()
