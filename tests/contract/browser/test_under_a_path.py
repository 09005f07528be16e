"""Under a path of a site: the pages in a real browser, whose scripts ask for nothing outside of it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from server.base.files import ROOT
from tests.contract.browser.conftest import EXERCISE, NewVisit, Visit, sync_api
from tests.support.served import Server, serving

PATH = "/balise"
expect = sync_api.expect
pytestmark = pytest.mark.slow


@pytest.fixture
def under(tmp_path: Path) -> Iterator[Server]:
    with serving(tmp_path / "data", BALISE_ROOT_PATH=PATH) as server:
        assert server.address.endswith(PATH)
        yield server


def watched(visitor: Visit) -> list[str]:
    """What is asked for outside of the path, from now on."""
    strays: list[str] = []

    def look(sent: sync_api.Request) -> None:
        if sent.url.startswith("http") and not re.match(rf"{PATH}(/|$)", urlsplit(sent.url).path):
            strays.append(sent.url)

    visitor.page.on("request", look)
    return strays


def test_one_reads_runs_answers_sends_and_teaches_under_a_path(under: Server, visit: NewVisit) -> None:
    visitor = visit(at=under)
    page, strays = visitor.page, watched(visitor)
    page.goto(under.teacher_link)
    for label, text in (("Nom", "Mme Martin"), ("Identifiant", "martin"), ("Mot de passe", "une phrase assez longue")):
        page.get_by_label(label, exact=False).first.fill(text)
    page.locator("main form button[type=submit]").first.click()
    page.wait_for_url(re.compile(f"{PATH}/"))
    expect(page.locator("header")).to_contain_text("Mme Martin")

    page.locator("header").get_by_role("link", name="Module L20").click()
    page.wait_for_url(re.compile(f"{PATH}/l20$"))
    visitor.open("/l20/lire/localiser")
    page.get_by_role("button", name="Exécuter").first.click()
    expect(page.get_by_role("log").first).not_to_be_empty()
    page.locator("[data-hands]").first.scroll_into_view_if_needed()
    expect(page.locator("[data-hands][data-ready=yes]").first).to_be_attached()
    page.locator("[data-source]").first.scroll_into_view_if_needed()
    expect(page.locator("[data-source] canvas").first).to_be_attached()
    asked = page.locator(".asked form").first
    asked.locator("input:not([type=hidden])").first.check()
    asked.get_by_role("button", name="Vérifier").click()
    expect(asked.get_by_role("status")).to_contain_text(re.compile("Juste|Pas encore"))

    visitor.open(EXERCISE)
    visitor.submit("def composer(a, b):\n    return a\n")
    page.get_by_role("button", name="Rejouer pas à pas").first.click()
    expect(page.locator("dialog.stepping .steps-keyword").first).to_be_visible()
    page.keyboard.press("Escape")
    visitor.submit((ROOT / "graders" / "l20" / "poses" / "solution.py").read_text(encoding="utf-8"))
    expect(page.locator("[data-part=verdict]")).to_contain_text("20")

    visitor.open("/classes")
    page.get_by_label("Nom").first.fill("MPSI 1")
    page.locator("main form[method=post] button[type=submit]").first.click()
    page.wait_for_url(re.compile(f"{PATH}/classes/"))
    visitor.open(urlsplit(page.url).path.removeprefix(PATH).partition("?")[0])
    expect(page.locator("[data-live]")).to_have_text("En direct")
    page.get_by_role("button", name="Se déconnecter").click()
    page.wait_for_url(re.compile(f"{PATH}/$"))
    expect(page.get_by_role("link", name="Se connecter")).to_be_visible()
    assert strays == []
