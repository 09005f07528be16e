"""A lesson in two browsers at once: the teacher's board moves by itself while a student is wrong, then right."""

from __future__ import annotations

from server.identity.models import Role
from tests.contract.browser.conftest import NewVisit, enters, sync_api
from tests.contract.browser.test_board import ROTATION
from tests.contract.browser.test_story import SOLUTION
from tests.support.classes import new_class, seat
from tests.support.served import Server
from tests.support.service import new_account

expect = sync_api.expect
MISTAKE = "La rotation est oubliée"


def test_a_mistake_comes_and_is_overcome_under_the_teacher_s_eyes(visit: NewVisit, server: Server) -> None:
    database = server.open_database()
    teacher, student = new_account(database, Role.teacher), new_account(database)
    made = new_class(database, teacher)
    seat(database, made, student)
    desk, place = enters(visit(), database, teacher), enters(visit(), database, student)
    board = desk.open(f"/classes/{made.id}")
    expect(board.locator("[data-live]")).to_have_text("En direct")
    expect(board.locator("[data-part=counts]")).to_contain_text("0 sur 1 a commencé")
    board.evaluate("window.neverReloaded = true")

    place.open()
    place.submit(ROTATION)
    expect(place.page.locator("[data-part=verdict]")).to_contain_text(MISTAKE)
    row = board.locator("[data-part=misconceptions] tr").filter(has_text=MISTAKE)
    expect(row.locator("td")).to_contain_text(["1", "1", "0", "—"])  # have it, had it, overcame it, after how many
    expect(board.locator(".spot-trying a")).to_be_visible()

    place.submit(SOLUTION)
    expect(row.locator("td")).to_contain_text(["0", "1", "1", "1"])
    expect(board.locator(".spot-solved a")).to_be_visible()
    expect(board.locator("[data-part=counts]")).to_contain_text("1 a ")
    assert board.evaluate("window.neverReloaded") is True
    database.close()
