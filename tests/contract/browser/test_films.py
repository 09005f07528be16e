"""A wrong filter, its verdict, and what it did at each step: in the player, without leaving the page."""

from __future__ import annotations

import re

import pytest

from tests.contract.browser.conftest import ROOT, NewVisit, sync_api
from tests.contract.browser.test_replays import COLOURS

expect = sync_api.expect
MOVES = True  # what is played is played as it is for who asks for nothing
PAGE = "/l20/exercices/predire2d"
FORGETFUL = (
    (ROOT / "graders/l20/predire2d/solution.py").read_text(encoding="utf-8")
    + """

def corriger2d(bel, scan_obs, sigma=0.5):
    nouvelle = np.zeros((H, W))
    for y, x in np.argwhere(libres):
        z = lidar((x + 0.5, y + 0.5, 0.0), 4)
        nouvelle[y, x] = np.exp(-np.sum((scan_obs - z) ** 2) / (2 * sigma**2))
    return nouvelle / nouvelle.sum()
"""
)


@pytest.mark.parametrize("width", [390, pytest.param(1280, marks=pytest.mark.slow)])
def test_a_wrong_filter_is_watched_where_it_went_wrong_beside_the_reference(visit: NewVisit, width: int) -> None:
    visitor = visit(width=width, color_scheme="light")
    page = visitor.open(PAGE)
    page.wait_for_selector("html.has-editor")
    visitor.submit(FORGETFUL)
    expect(page.locator(".films figure.replay[data-source]")).to_have_count(1)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url) if "/rejeux/" in request.url else None)
    line = page.locator(".check-failed", has=page.locator("a[href='#film-localisation']"))
    line.locator("summary").first.click()
    line.get_by_role("link", name="Revoir ce que votre code a fait").click()
    film = page.locator("#film-localisation")
    expect(film.locator("summary").first).to_be_focused()
    expect(film.locator("canvas.replay-canvas")).to_have_count(2)
    expect(film.locator(".replay-counter")).to_have_text("1 / 17")
    assert len(asked) == 1, "nothing is asked before somebody looks"
    film.get_by_role("button", name="Aller là où ça s’écarte").click()
    expect(film.locator(".replay-caption")).to_contain_text("C’est ici que votre croyance s’écarte")
    mine, theirs = film.locator("canvas.replay-canvas").all()
    assert min(mine.evaluate(COLOURS), theirs.evaluate(COLOURS)) > 4
    assert mine.evaluate("canvas => canvas.toDataURL()") != theirs.evaluate("canvas => canvas.toDataURL()")
    mine.focus()
    page.keyboard.press("End")
    expect(film.locator(".replay-counter")).to_have_text("17 / 17")
    expect(film.locator(".replay-summary")).to_contain_text("le robot est perdu")
    expect(mine).to_have_attribute("aria-label", re.compile("référence.{50,}"))
    expect(film.locator(".replay-settings")).to_be_hidden()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    if width == 1280:  # what axe looks at is the same at any width
        from tests.contract.browser.test_accessibility import check

        check(visitor, f"a film at {width} pixels", exclude=[[".statement"], [".hints"], [".cm-editor"]])


@pytest.mark.slow
def test_without_scripts_the_verdict_says_what_is_missing(visit: NewVisit) -> None:
    visitor = visit(java_script_enabled=False)
    page = visitor.page
    page.goto(visitor.server.address + PAGE)
    page.locator("#code").fill(FORGETFUL)
    page.locator("#envoyer").click()
    page.wait_for_selector("#verdict[data-status=done]", timeout=180_000)
    page.locator("#film-localisation summary").click()
    expect(page.locator("#film-localisation")).to_contain_text("Cette animation se joue avec JavaScript")
    expect(page.locator("#film-localisation .replay-stage")).to_be_hidden()
