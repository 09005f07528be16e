"""What a page asks of the database: as much for forty attempts as for one, and never what it does not show."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from uuid import uuid4

import pytest
from sqlalchemy import event, select, text

from server.database import Database
from server.gradebook import repository
from server.gradebook.models import Grading
from server.identity import tokens
from server.identity.models import Account
from server.pages.service import ATTEMPTS_A_PAGE
from server.submissions.models import Submission
from server.submissions.service import SubmissionService
from tests.support.counting import Counted
from tests.support.quick import some
from tests.support.service import ADDRESS, EXERCISE, QUIET, Site, worker_of

FORM = {"name": "Ada L.", "login": "ada@example.org", "password": "notes sur la machine"}
PAGE = "/l20/exercices/poses"
HEAVY = re.compile(r"\b(submission\.source|grading\.verdict|grading\.figures|grading\.films)\b")


@dataclass
class Ada:
    """Somebody who sends one attempt after another, and reads every page."""

    site: Site
    account: Account
    headers: dict[str, str]
    sent: list[Submission] = field(default_factory=list)

    def send(self, count: int, *, graded: bool = True) -> None:
        generous = self.site.settings.model_copy(update={"submission_burst": 1000, "waiting_each": 1000})
        store = SubmissionService(generous, QUIET)
        worker = worker_of(self.site.database, generous)
        for number in range(count):
            code = f"x = {number}  # outcome: {'ok' if number % 7 == 3 else 'wrong_answer'}"
            with self.site.database.write() as db:
                self.sent.append(store.submit(db, self.account, EXERCISE, code, address=ADDRESS))
            assert not graded or worker.run_one()

    @property
    def pages(self) -> dict[str, str]:
        latest = self.sent[-1].id
        return {
            "home": "/",
            "module": "/l20",
            "exercise": PAGE,
            "attempts": f"{PAGE}/essais",
            "attempt": f"/soumissions/{latest}",
            "verdict": f"/soumissions/{latest}/verdict",
            "api list": "/api/v1/exercises",
            "api exercise": f"/api/v1/exercises/{EXERCISE}",
            "api submission": f"/api/v1/submissions/{latest}",
        }

    def asked(self) -> dict[str, list[str]]:
        """The statements of each page."""
        return {name: self.statements(path) for name, path in self.pages.items()}

    def statements(self, path: str) -> list[str]:
        with Counted(self.site.database) as counted:
            answer = self.site.client.get(path, headers=self.headers if path.startswith("/api") else {})
        assert answer.status_code == 200, answer.text
        return counted.statements


@pytest.fixture
def ada(site: Site) -> Ada:
    site.client.post("/inscription", data=FORM)
    with site.database.write() as db:
        account = db.execute(select(Account)).scalar_one()
        _, secret = tokens.create_token(db, account, "essai", site.settings)
    headers = {"Authorization": f"Bearer {secret}"}
    site.client.get("/api/v1/exercises", headers=headers)  # the first use of a token is noted
    site.client.get("/")  # and a first visit
    return Ada(site, account, headers)


@pytest.mark.parametrize("graded", [True, False])
def test_no_page_asks_more_for_more_attempts(ada: Ada, graded: bool) -> None:
    ada.send(4)  # the last one succeeds: what is counted is the same from then on
    ada.send(1, graded=graded)
    few = {name: len(statements) for name, statements in ada.asked().items()}
    ada.send(35)
    ada.send(1, graded=graded)
    assert {name: len(statements) for name, statements in ada.asked().items()} == few
    assert max(few.values()) <= 16


@contextmanager
def loaded() -> Iterator[list[object]]:
    """The submissions and gradings that are loaded whole within the block."""
    rows: list[object] = []

    def note(row: object, _context: object) -> None:
        rows.append(row)

    for kind in (Submission, Grading):
        event.listen(kind, "load", note)
    yield rows
    for kind in (Submission, Grading):
        event.remove(kind, "load", note)


def test_sources_verdicts_and_figures_are_read_of_the_one_that_is_shown(ada: Ada) -> None:
    ada.send(40)
    shown = {"exercise", "attempt", "verdict", "api submission"}
    compared = shown - {"api submission"}  # a page tells what was mended since the verdict before
    for name, path in some(ada.pages.items()):
        with loaded() as rows:
            heavy = [statement for statement in ada.statements(path) if HEAVY.search(statement)]
        expected = 1 if name in shown else 0
        assert (len(heavy), len(rows)) == (expected + (name in compared), 2 * expected), name
        for statement in heavy:
            assert not re.search(r"grading\.(figures|films)\b", statement)
            assert "submission.id = ?" in statement or "LIMIT ?" in statement


def test_lists_of_attempts_stand_on_an_index(sqlite: Database) -> None:
    with Counted(sqlite) as counted, sqlite.read() as db:
        repository.list_attempts_with_total(db, uuid4(), EXERCISE, limit=50, offset=0)
        (statement,) = counted.statements
        plan = db.execute(text(f"EXPLAIN QUERY PLAN {statement.replace('?', '1')}")).all()
    told = " ".join(str(row[3]) for row in plan)
    assert "USING INDEX ix_submission_attempts" in told or "USING COVERING INDEX ix_submission_attempts" in told
    assert "SCAN submission" not in told


def numbers(page: str) -> list[int]:
    return [int(number) for number in re.findall(r'aria-label="Essai n° (\d+),', page)]


def test_attempts_are_listed_a_page_at_a_time(ada: Ada) -> None:
    ada.send(2 * ATTEMPTS_A_PAGE + 3, graded=False)
    read = [ada.site.client.get(f"{PAGE}/essais?page={number}").text for number in (1, 2, 3)]
    last = 2 * ATTEMPTS_A_PAGE + 3
    assert [numbers(page) for page in read] == [
        list(range(last, last - ATTEMPTS_A_PAGE, -1)),
        list(range(last - ATTEMPTS_A_PAGE, 3, -1)),
        [3, 2, 1],
    ]
    links = [re.findall(r'<a class="button" rel="(\w+)" href="([^"]+)">([^<]+)', page) for page in read]
    older, newer = "Plus anciens", "Plus récents"
    assert links == [
        [("next", f"{PAGE}/essais?page=2", older)],
        [("prev", f"{PAGE}/essais", newer), ("next", f"{PAGE}/essais?page=3", older)],
        [("prev", f"{PAGE}/essais?page=2", newer)],
    ]
    assert "Essais n° 1 à 3, sur 103 en tout." in read[2]
    assert ada.site.client.get(f"{PAGE}/essais").text == read[0]
    assert ada.site.client.get(f"{PAGE}/essais?page=4").status_code == 404
    for refused in ("0", "-1", "zut", "1" * 30):
        assert ada.site.client.get(f"{PAGE}/essais?page={refused}").status_code == 422


def test_few_attempts_need_no_other_page(ada: Ada) -> None:
    ada.send(2, graded=False)
    page = ada.site.client.get(f"{PAGE}/essais").text
    assert numbers(page) == [2, 1]
    assert "Plus anciens" not in page
    assert "Plus récents" not in page
