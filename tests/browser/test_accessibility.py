"""axe finds nothing on any page, in light and in dark, before and after a verdict.

The two themes have the same markup: every rule runs in light, those on colours run again in dark.
"""

from __future__ import annotations

from typing import Any

import pytest

from tests.browser.conftest import EXERCISE, NewVisit, Visit
from tests.browser.test_story import SOLUTION, WRONG

axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed")


COLOURS = {"runOnly": {"type": "rule", "values": ["color-contrast", "link-in-text-block"]}}


def check(visitor: Visit, what: str, options: dict[str, Any] | None = None) -> None:
    found = axe.Axe().run(visitor.page, options=options).response["violations"]
    told = [f"{one['id']}: {node['html'][:160]} — {node['failureSummary']}" for one in found for node in one["nodes"]]
    assert told == [], what


@pytest.mark.parametrize(("scheme", "options"), [("light", None), ("dark", COLOURS)])
def test_pages_of_a_student(visit: NewVisit, scheme: str, options: dict[str, Any] | None) -> None:
    visitor = visit(color_scheme=scheme, expected="404")
    page = visitor.open()
    check(visitor, "exercise, fresh", options)
    visitor.submit("print('bonjour')\n" + WRONG)
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    check(visitor, "exercise, wrong", options)
    attempt = page.locator(".attempts a").first.get_attribute("href")
    visitor.submit(SOLUTION)
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    check(visitor, "exercise, right", options)
    for path in ("/", "/l20", attempt, f"{EXERCISE}/essais", "/connexion", "/inscription", "/compte", "/nulle-part"):
        page.goto(visitor.server.address + str(path))
        check(visitor, str(path), options)


def test_pages_of_a_teacher(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.page
    page.goto(visitor.server.teacher_link)
    check(visitor, "welcome")
    page.get_by_label("Nom affiché").fill("Mme Martin")
    page.get_by_label("Identifiant").fill("martin")
    page.get_by_label("Mot de passe").fill("une phrase assez longue")
    page.locator("main form button").click()
    visitor.open()
    page.get_by_role("button", name="Ouvrir le corrigé à tous les élèves").click()
    page.wait_for_selector("html.has-editor")
    page.locator("#corrige summary").click()
    check(visitor, "exercise, teacher")
    page.goto(visitor.server.address + "/compte")
    check(visitor, "account")
