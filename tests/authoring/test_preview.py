"""A preview's pages: what they add to the real ones, for whom, and how a change becomes another version."""

from __future__ import annotations

import json
import os
import re
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from server.app import create_app
from server.authoring.preview.pages import PreviewMiddleware, ServedVersion, router
from server.authoring.preview.serving import preview_settings
from server.authoring.preview.supervising import PreviewSession, PreviewSupervisor, _stop_version
from server.course import Course, Problem
from server.database import Database
from server.submissions.models import Submission
from tests.support.client import TestClient
from tests.support.quick import migrated


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("kept")


@pytest.fixture(scope="module")
def database(kept: Path) -> Iterator[Database]:
    made = migrated(preview_settings(kept))
    yield made
    made.close()


@pytest.fixture(scope="module")
def preview(place: Path, course: Course, kept: Path, database: Database) -> Iterator[TestClient]:
    app = create_app(preview_settings(kept), course=course)
    fault = Problem(place / "curriculum" / "l21" / "module.toml", 3, "un <défaut>")
    version = app.state.preview = ServedVersion(PreviewSession(place, kept, 7), (fault,), None)  # type: ignore[arg-type]
    app.include_router(router)
    with TestClient(PreviewMiddleware(app, version, course), base_url="http://localhost:8010") as client:
        yield client


def test_each_page_says_what_is_wrong_and_where_one_tries(preview: TestClient, kept: Path) -> None:
    page = preview.get("/l21/exercices/gain").text
    assert "<code>curriculum/l21/module.toml:3</code> <span>un &lt;défaut&gt;</span>" in page
    assert 'data-version="7"' in page
    assert page.index('href="/apercu/l21/gain"') > page.index('id="apercu"')
    assert page.endswith("</body>\n</html>") or page.rstrip().endswith("</html>")
    assert 'id="apercu"' in preview.get("/l21/exercices/nulle-part").text, "on an error too"
    (kept / "faults-7.json").write_text(json.dumps([]))
    assert "rien à corriger" in preview.get("/l21").text
    assert preview.get("/static/x/js/preview.js").text.count("EventSource")


def test_it_answers_this_machine_alone(preview: TestClient) -> None:
    for host in ("balise.example", "127.0.0.1.balise.example", "localhost.balise.example:8010"):
        assert preview.get("/l21", headers={"host": host}).status_code == 403
    assert preview.get("/l21", headers={"host": "127.0.0.1:8010"}).status_code == 200
    site, asks = {"sec-fetch-site": "cross-site"}, "/apercu/l21/gain"
    for how, status in (("no-cors", 403), ("navigate", 200)):
        dest = "document" if how == "navigate" else "image"
        assert preview.get(asks, headers={**site, "sec-fetch-mode": how, "sec-fetch-dest": dest}).status_code == status
    framed = {**site, "sec-fetch-mode": "navigate", "sec-fetch-dest": "iframe"}
    assert preview.get(asks, headers=framed).status_code == 403
    assert preview.get(asks, headers={"sec-fetch-site": "same-origin", "sec-fetch-mode": "cors"}).status_code == 200
    forged = preview.post("/apercu/l21/gain/0", headers={"origin": "http://autre.example"}, follow_redirects=False)
    assert forged.status_code == 403


def test_checks_show_what_they_ask_and_what_is_awaited(preview: TestClient) -> None:
    page = preview.get("/apercu/l21/gain").text
    assert "gain(2, 10, 0,25)" in page
    assert re.findall(r"(\d+) appels", page) == ["3", "8"]
    other = preview.get("/apercu/l21/gain?graine=2").text
    assert re.findall(r"gain\(.*?\)", page)[:3] == re.findall(r"gain\(.*?\)", other)[:3]
    assert re.findall(r"gain\(.*?\)", page)[3:] != re.findall(r"gain\(.*?\)", other)[3:], "the draws"
    assert preview.get("/apercu/l21/nulle-part").status_code == 404
    assert preview.get("/apercu/l21/gain/figures/rien.svg").status_code == 404


def test_figures_of_checks_have_their_legend(preview: TestClient) -> None:
    page, words = preview.get("/apercu/l21/gain").text, "Un segment de a à b, avec en bleu le point attendu"
    alts = re.findall(r'alt="(Figure[^"]+)"', page)
    assert len(alts) == page.count("<figcaption") == 2
    assert all(f"sur son premier cas. {words}" in alt for alt in alts)
    assert page.count(f"<strong>Figure.</strong> {words}") == 2


def test_what_is_tried_is_sent_as_a_student_would(preview: TestClient, course: Course, database: Database) -> None:
    for exercise, number in (("gain", 2), ("verification", 0), ("calcul", 0)):
        answer = preview.post(f"/apercu/l21/{exercise}/{number}", follow_redirects=False)
        assert answer.status_code == 303
        assert preview.get(answer.headers["location"]).status_code == 200
    assert preview.post("/apercu/l21/gain/99").status_code == 404
    with database.read() as db:
        sent = {row.exercise: row for row in db.query(Submission)}
    assert b"b + t * (a - b)" in sent["l21/gain"].source
    for name in ("l21/verification", "l21/calcul"):
        exercise, row = course.exercises[name], sent[name]
        assert exercise.grader.grade(row.source, None, seed=row.seed, version="").verdict.score == 1, (
            "of one's own deal"
        )  # type: ignore[arg-type]


def test_a_version_that_does_not_come_up_leaves_the_one_before_it(tmp_path: Path) -> None:
    """A process for each version, on one address, which answers all along."""
    text, said = tmp_path / "text", list[str]()
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def serve(session: PreviewSession, listener: socket.socket, ready: Any) -> None:
            written = text.read_text()
            if written == "bad":
                raise SystemExit
            ready()
            while True:
                with listener.accept()[0] as one:
                    one.sendall(f"{session.generation} {written}".encode())

        def asked() -> str:
            with socket.create_connection(listener.getsockname()) as one:
                return one.recv(100).decode()

        supervisor = PreviewSupervisor(tmp_path, listener, serve, lambda session: time.sleep(60), said.append)
        supervisor.data_dir = tmp_path
        text.write_text("one")
        running = supervisor._start_version()
        answers = [asked()]
        for written in ("bad", "two"):
            text.write_text(written)
            supervisor._restart_version(running)
            answers += [asked()]
        _stop_version(running)
    assert answers == ["1 one", "1 one", "3 two"]
    assert [line for line in said if "ne démarre pas" in line]
    with pytest.raises(ProcessLookupError):
        os.kill(running.checker, 0)
