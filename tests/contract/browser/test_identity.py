"""A page whose session has ended, or whose work was saved elsewhere, in a browser: nothing is lost, and all is said."""

from __future__ import annotations

from sqlalchemy import delete, select

from server.assignments.models import Mode
from server.database import Database
from server.identity.models import Account, BrowserSession, Role
from server.submissions.models import Submission
from tests.contract.browser.conftest import EXERCISE, NewVisit, Visit, enters, sync_api
from tests.support.classes import assign, new_class, seat
from tests.support.served import Server
from tests.support.service import new_account

expect = sync_api.expect
LOGIN, PASSWORD = "zoe.revient", "notes sur la machine"
CALM = 1500  # milliseconds, as in `saves.js`


def database_of(server: Server) -> Database:
    return server.open_database()


def test_a_session_that_ends_while_typing_loses_nothing(visit: NewVisit, server: Server) -> None:
    database, visitor = database_of(server), visit(expected="401")
    page = visitor.page
    page.goto(f"{server.address}/inscription?suite={EXERCISE}")
    for name, value in {"name": "Zoé", "login": LOGIN, "password": PASSWORD}.items():
        page.fill(f"#{name}", value)
    page.locator("main").get_by_role("button", name="Créer le compte").click()
    page.wait_for_selector("html.has-editor")
    visitor.write("x = 1  # tapé avant\n")
    with database.write() as db:
        account_id = db.scalars(select(Account.id).where(Account.login == LOGIN)).one()
        db.execute(delete(BrowserSession).where(BrowserSession.account_id == account_id))
    page.get_by_role("button", name="Envoyer", exact=True).click()
    expect(page.locator("#essai-message")).to_contain_text("Vous n’êtes plus connecté")
    page.get_by_role("link", name="Se connecter et revenir ici").click()
    page.fill("#login", LOGIN)
    page.fill("#password", PASSWORD)
    page.locator("main").get_by_role("button", name="Se connecter").click()
    expect(page.locator(".cm-content")).to_contain_text("# tapé avant")
    page.get_by_role("button", name="Envoyer", exact=True).click()
    expect(page.locator("[data-part=verdict]")).to_be_visible()
    with database.read() as db:
        sent = db.scalars(select(Submission).where(Submission.account_id == account_id)).one()
    assert sent.code.startswith("x = 1  # tapé avant")


def writes(visitor: Visit, code: str) -> None:
    """Write, and let the time pass after which what is written is saved by itself."""
    visitor.write(code)
    visitor.page.clock.fast_forward(CALM)


def test_work_saved_on_another_machine_is_not_replaced_unasked(visit: NewVisit, server: Server) -> None:
    database = database_of(server)
    teacher, account = new_account(database, Role.teacher), new_account(database)
    made = new_class(database, teacher)
    seat(database, made, account)
    test = assign(database, made, "l20/poses", mode=Mode.test, duration_minutes=60)
    here, there = (enters(visit(expected="409"), database, account) for _ in range(2))
    for visitor in (here, there):
        visitor.page.clock.install()
    here.page.on("dialog", lambda dialog: dialog.accept())
    here.page.goto(f"{server.address}/classes/{made.id}/devoirs/{test.id}/composer")
    here.page.get_by_role("button", name="Commencer").click()
    expect(here.page.locator(".countdown")).to_contain_text("il reste")
    here.open()
    there.open()
    writes(there, "x = 2")
    saved_there, saved_here = there.page.locator("#enregistre"), here.page.locator("#enregistre")
    expect(saved_there).to_contain_text("enregistré à")
    writes(here, "x = 1")
    expect(saved_here).to_contain_text("Une autre version a été enregistrée")
    here.page.get_by_role("button", name="Garder la mienne").click()
    expect(saved_here).to_contain_text("enregistré à")
    writes(there, "x = 3")
    expect(saved_there).to_contain_text("Une autre version a été enregistrée")
    there.page.get_by_role("button", name="Prendre l’autre").click()
    expect(there.page.locator(".cm-content")).to_have_text("x = 1")
