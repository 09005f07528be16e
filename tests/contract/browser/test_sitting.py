"""A test in a browser: what is written is kept by itself, the time is told, what is on the screen at the end counts."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta

import pytest
from sqlalchemy import select, update

from server.assignments import sittings
from server.assignments.models import Assignment, Mode, Sitting
from server.database import Database, utc_now
from server.identity.models import Account, Role
from server.submissions.models import Submission
from tests.contract.browser.conftest import EXERCISE, NewVisit, Visit, enters, sync_api
from tests.contract.browser.test_accessibility import check
from tests.support.classes import assign, new_class, seat
from tests.support.live import until
from tests.support.served import Server
from tests.support.service import new_account

expect = sync_api.expect


@dataclass
class Sat:
    """A student who may sit a test of an hour, in the server's own database."""

    server: Server
    database: Database
    account: Account
    test: Assignment

    @property
    def path(self) -> str:
        return f"/classes/{self.test.class_id}/devoirs/{self.test.id}/composer"

    def enters(self, visitor: Visit) -> Visit:
        return enters(visitor, self.database, self.account)

    def codes(self) -> list[str]:
        query = select(Submission).where(Submission.account_id == self.account.id).order_by(Submission.created_at)
        with self.database.read() as db:
            return [one.code for one in db.execute(query).scalars()]


@pytest.fixture
def sat(server: Server) -> Sat:
    database = server.open_database()
    teacher, account = new_account(database, Role.teacher), new_account(database)
    made = new_class(database, teacher)
    seat(database, made, account)
    test = assign(database, made, "l20/poses", mode=Mode.test, duration_minutes=60)
    return Sat(server, database, account, test)


def kept(visitor: Visit) -> None:
    expect(visitor.page.locator("#enregistre")).to_contain_text("enregistré à")


@pytest.mark.slow
def test_what_is_on_the_screen_at_the_end_counts(visit: NewVisit, sat: Sat) -> None:
    here, there = sat.enters(visit()), sat.enters(visit(width=390))
    page = here.page
    page.on("dialog", lambda dialog: dialog.accept())
    page.goto(sat.server.address + sat.path)
    check(here, "a test that one may begin")
    page.get_by_role("button", name="Commencer").click()
    expect(page.locator(".countdown")).to_contain_text("il reste")
    page.locator("summary", has_text="Rendre").click()
    check(here, "a test that one sits")
    here.open()
    here.write("x = 1")
    kept(here)
    check(here, "an exercise of a test", exclude=[[".statement"]])
    there.open()
    expect(there.page.locator(".cm-content")).to_have_text("x = 1")
    there.write("x = 2")
    kept(there)
    here.open()
    expect(page.locator(".cm-content")).to_have_text("x = 2")
    expect(page.locator("#versions")).to_be_visible()
    with sat.database.write() as db:
        began = utc_now() - timedelta(minutes=60) + timedelta(seconds=12)
        db.execute(update(Sitting).where(Sitting.account_id == sat.account.id).values(began_at=began))
    here.open()
    here.write("x = 3")
    expect(page.locator("#annonce")).to_contain_text("Le temps est écoulé")
    expect(page.locator(".test-over")).to_be_visible()
    until(lambda: sat.codes() == ["x = 3"], "what was written in the last seconds is sent")
    check(here, "an exercise of a test that is over", exclude=[[".statement"]])


@pytest.mark.slow
def test_an_end_that_is_put_off_is_told_at_once(visit: NewVisit, sat: Sat) -> None:
    here = sat.enters(visit())
    page = here.page
    page.on("dialog", lambda dialog: dialog.accept())
    page.goto(sat.server.address + sat.path)
    page.get_by_role("button", name="Commencer").click()
    with sat.database.write() as db:
        began = utc_now() - timedelta(minutes=60) + timedelta(seconds=8)
        db.execute(update(Sitting).where(Sitting.account_id == sat.account.id).values(began_at=began))
    here.open()
    expect(page.locator(".countdown")).to_contain_text("il reste")
    with sat.database.write() as db:
        db.execute(update(Assignment).where(Assignment.id == sat.test.id).values(duration_minutes=90))
    expect(page.locator("#annonce")).to_contain_text("La fin du contrôle a changé")
    expect(page.locator(".countdown")).to_contain_text("il reste 30 min")
    expect(page.locator(".test-over")).to_have_count(0)


@pytest.mark.slow
def test_without_a_script_one_begins_saves_and_hands_in(visit: NewVisit, sat: Sat) -> None:
    visitor = sat.enters(visit(java_script_enabled=False))
    page = visitor.page
    page.goto(sat.server.address + sat.path)
    page.get_by_role("button", name="Commencer").click()
    page.goto(sat.server.address + EXERCISE)
    page.locator("#code").fill("x = 4")
    page.get_by_role("button", name="Enregistrer").click()
    expect(page.locator("#enregistre")).to_contain_text("enregistré le")
    page.get_by_role("link", name="Le contrôle").click()
    page.locator("summary", has_text="Rendre").click()
    page.get_by_role("button", name="Rendre définitivement").click()
    expect(page.locator("main")).to_contain_text("Rendu le")
    assert sat.codes() == ["x = 4"]


def test_a_file_that_does_not_run_is_told_while_one_sits(visit: NewVisit, sat: Sat) -> None:
    """By itself, on the page from which it was sent; of one that runs nothing is told."""
    with sat.database.write() as db:
        sittings.begin_sitting(db, sat.test, sat.account.id, (), utc_now())
    here = sat.enters(visit(width=390))
    here.open()
    here.write("def composer(a, b)\n    return a")
    here.page.get_by_role("button", name="Envoyer").click()
    verdict = here.page.locator("#verdict")
    expect(verdict).to_contain_text("reçu, mais à corriger", timeout=15_000)
    expect(verdict).to_contain_text("Ligne 1")
    expect(verdict).not_to_contain_text("/ 20")
    check(here, "a file that does not run, in a test")
    here.open()
    here.write("def composer(a, b):\n    return a\ndef inverse(a):\n    return a\ndef relatif(a, b):\n    return a")
    here.page.get_by_role("button", name="Envoyer").click()
    expect(verdict).to_contain_text("Essai n° 2 reçu")
    expect(verdict).not_to_contain_text("à corriger")
