"""What the service does now: for an administrator alone, true, and legible in a terminal of eighty columns."""

from __future__ import annotations

import json
import logging
from typing import Any

import pytest

from server.base.app_services import get_service
from server.base.counters import VisitCounter
from server.base.logs import RECENT_ERRORS
from server.cli import main, top
from server.grading.job_lanes import JOB_LANES
from server.health.metrics import PrometheusMetrics
from server.identity.models import Role
from server.queue.lease_owner import process_owner
from tests.support.client import TestClient
from tests.support.service import EXERCISE, QUIET, Site

SECRET = "x = 'le code de Bob'\n"


@pytest.fixture
def administrator(site: Site) -> dict[str, str]:
    return site.token(Role.administrator)


def test_the_state_is_for_administrators(site: Site, administrator: dict[str, str]) -> None:
    assert site.client.get("/statusz").status_code == 401
    assert site.client.get("/statusz", headers=site.token()).status_code == 403
    assert site.client.get("/statusz", headers=site.token(Role.teacher)).status_code == 403
    answer = site.client.get("/statusz", headers=administrator)
    assert (answer.status_code, answer.headers["cache-control"]) == (200, "no-store")


def test_it_tells_what_waits_who_grades_and_how_fast_and_nothing_of_what_was_sent(
    site: Site, administrator: dict[str, str]
) -> None:
    def state() -> Any:
        return site.client.get("/statusz", headers=administrator).json()

    student = site.token()
    for _ in range(2):
        site.submit(student, SECRET)
    assert state()["queue"] == [{"kind": "grade", "waiting": 2, "oldest": pytest.approx(0, abs=60), "running": 0}]
    with site.database.write() as db:
        lease = QUIET.claim(db, process_owner(1), ["grade"], 30)
    assert lease is not None
    (busy,) = state()["workers"]
    assert (busy["pid"], busy["kind"], busy["exercise"], busy["tries"]) == (1, "grade", EXERCISE, 1)
    assert (state()["queue"][0]["waiting"], state()["queue"][0]["running"]) == (1, 1)
    with site.database.write() as db:
        QUIET.requeue_untried(db, lease)
    while site.worker.run_one():
        pass
    site.submit(student, "outcome: internal_error")
    while site.worker.run_one():
        pass
    told = state()
    assert told["verdicts"]["per_minute"] == pytest.approx(3 / 5)
    assert 0 <= told["verdicts"]["p50"] <= told["verdicts"]["p95"]
    assert [fault["where"] for fault in told["faults"]] == [EXERCISE]
    assert told["process"]["visitors"] >= 1
    assert "Bob" not in json.dumps(told)
    assert "192.0.2" not in json.dumps(told)


def test_visitors_are_counted_for_a_while_and_who_watches_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    visits = VisitCounter(seconds=300)
    for who in (b"a", b"b", b"a"):
        visits.record(who)
    assert (visits.recent_visitors(), visits.requests_in_last_minute()) == (2, 3)
    assert not {b"a", "a"} & set(visits._seen)
    monkeypatch.setattr("server.base.counters.time.monotonic", lambda: 1e9)
    assert visits.requests_in_last_minute() == 0


def test_latest_logged_errors_are_shown_on_one_line_each(site: Site, administrator: dict[str, str]) -> None:
    record = logging.LogRecord("server.x", logging.ERROR, "", 0, "le modèle %s a cessé\nsuite", ("numpy",), None)
    RECENT_ERRORS.handle(record)
    faults = site.client.get("/statusz", headers=administrator).json()["faults"]
    assert ("server.x", "le modèle numpy a cessé") in {(one["where"], one["message"]) for one in faults}
    assert all("suite" not in one["message"] for one in faults)


@pytest.fixture
def shown(site: Site, administrator: dict[str, str], monkeypatch: pytest.MonkeyPatch, capsys: Any) -> Any:
    """What `balise top --server` writes."""
    client = TestClient(site.app, headers=administrator)
    monkeypatch.setattr("server.cli.remote.make_client", lambda _server, _token: client)

    def write(*more: str) -> str:
        assert main(["top", "--server", "https://balise.example", "--token", "t", *more]) == 0
        return str(capsys.readouterr().out)

    return write


def test_the_screen_is_plain_and_fits_eighty_columns(site: Site, shown: Any) -> None:
    get_service(site.app, PrometheusMetrics).set_wall_states({"seccomp": True, "cgroup-mémoire": False})
    RECENT_ERRORS.handle(logging.LogRecord("server.x", logging.ERROR, "", 0, "\033[2J" + "long " * 60, (), None))
    site.submit(site.token())
    screen = shown("--once")
    assert all(len(line) <= 80 for line in screen.splitlines())
    assert all(character.isprintable() or character == "\n" for character in screen), "no terminal is commanded"
    for said in ("Visiteurs", "Protections : 1/2", "! Protections absentes : cgroup-mémoire", "corrections", "aucun"):
        assert said in screen
    assert json.loads(shown("--json"))["process"]["walls"] == {"seccomp": True, "cgroup-mémoire": False}


def test_it_is_read_in_the_database_too_and_told_where_there_is_none(
    site: Site, capsys: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Any
) -> None:
    monkeypatch.setenv("BALISE_DATABASE_URL", site.settings.sqlalchemy_url)
    site.submit(site.token())
    assert main(["top", "--once"]) == 0
    assert "corrections" in capsys.readouterr().out
    monkeypatch.setenv("BALISE_DATABASE_URL", f"sqlite:///{tmp_path / 'none.sqlite3'}")
    assert main(["top", "--once"]) == 2
    assert "il n’y a pas de base de données" in capsys.readouterr().err
    assert not (tmp_path / "none.sqlite3").exists()


def test_every_kind_of_job_has_its_words() -> None:
    assert set(top.KINDS) == set(JOB_LANES)


def test_a_refusal_while_the_service_starts_again_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(top, "REFRESH_SECONDS", 0)
    answers: list[Any] = [top.CommandError("il redémarre"), {"ok": True}]

    def read() -> Any:
        answer = answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    assert top._read_with_retries(read) == {"ok": True}
    answers += [top.CommandError("il redémarre")] * 2
    with pytest.raises(top.CommandError):
        top._read_with_retries(read)


def test_durations_are_formatted_for_people() -> None:
    said = {0.0: "0 ms", 0.0416: "42 ms", 3.25: "3,2 s", 59: "59 s", 61: "1 min 01", 7260: "2 h 01"}
    assert {value: top._format_seconds(value) for value in said} == said


def test_refused_access_is_explained(site: Site, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    for headers, why in (({"Authorization": "Bearer balise_faux"}, "jeton"), (site.token(), "administrateur")):
        client = TestClient(site.app, headers=headers)
        monkeypatch.setattr("server.cli.remote.make_client", lambda _server, _token, client=client: client)
        assert main(["top", "--server", "https://balise.example", "--token", "t", "--once"]) == 2
        assert why in capsys.readouterr().err
