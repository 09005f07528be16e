"""The board of a class in two browsers at once: it changes while a student works, and who reads it is not moved."""

from __future__ import annotations

import pytest

from tests.contract.browser.conftest import NewVisit, Visit, sync_api
from tests.contract.browser.test_accessibility import check
from tests.contract.browser.test_classes import creates, fill, teacher

expect = sync_api.expect
ROTATION = """import numpy as np

def ramener(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)

def composer(a, b):
    return np.array([a[0] + b[0], a[1] + b[1], ramener(a[2] + b[2])])

def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], ramener(-a[2])])

def relatif(a, b):
    return composer(inverse(a), b)
"""


def student(visit: NewVisit, code: str, given: str, **options: int) -> Visit:
    visitor = visit(**options)
    visitor.page.goto(f"{visitor.server.address}/rejoindre/{code}")
    fill(visitor, {"Prénom": given, "Nom": "Lovelace"}, "Rejoindre la classe")
    return visitor


@pytest.mark.slow
def test_the_board_follows_a_lesson(visit: NewVisit) -> None:
    martin = teacher(visit, "martin-tableau")
    page = martin.page
    page.goto(martin.server.address + "/classes")
    creates(martin, "MPSI 3")
    home, code = page.url, page.locator(".join-code").inner_text()
    ada = student(visit, code, "Ada")
    page.goto(home)
    expect(page.locator("[data-live]")).to_have_text("En direct")
    expect(page.locator("[data-part=counts]")).to_contain_text("0 sur 1 a commencé")
    page.locator(".board-rule summary").click()
    page.locator(".board-rule summary").focus()

    ada.open()
    ada.submit(ROTATION)
    expect(page.locator("[data-part=counts]")).to_contain_text("1 sur 1 a commencé")
    expect(page.locator(".spot-trying a")).to_be_visible()
    expect(page.get_by_role("link", name="La rotation est oubliée", exact=True)).to_be_visible()
    check(martin, "a board")

    page.get_by_role("link", name="La rotation est oubliée", exact=True).focus()
    ada.submit(ROTATION.replace("a[0] + b[0]", "0.0 + a[0] + b[0]"))
    expect(page.locator(".spot-trying .visually-hidden")).to_contain_text("2 essais")
    assert page.evaluate("document.activeElement.textContent") == "La rotation est oubliée"
    bob = student(visit, code, "Bob")
    bob.open()
    bob.submit("x = 1")
    expect(page.get_by_role("link", name="Bob Lovelace")).to_have_count(1)

    page.get_by_role("link", name="La rotation est oubliée", exact=True).click()
    expect(page.locator("pre.code")).to_contain_text("composer")
    check(martin, "a misconception")
    page.get_by_role("link", name="Projeter à la classe").click()
    page.get_by_role("link", name="Projeter l’explication seule").click()
    check(martin, "the projection")
    page.set_viewport_size({"width": 1024, "height": 768})
    assert page.evaluate("document.documentElement.scrollHeight") <= 768
    phone = visit(width=390, height=844)
    phone.page.context.add_cookies(page.context.cookies())
    phone.page.goto(home)
    assert phone.page.evaluate("document.documentElement.scrollWidth") == 390
