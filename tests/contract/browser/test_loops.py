"""Closed loops, the chain of the practical work and the node: wrong, watched and understood, then right."""

from __future__ import annotations

import pytest

from tests.contract.browser.conftest import ROOT, NewVisit, Visit, sync_api
from tests.contract.browser.test_replays import COLOURS
from tests.contract.browser.test_story import SOLUTION as POSES

expect = sync_api.expect
MOVES = True  # what is played is played as it is for who asks for nothing
Page = sync_api.Page
#: Seconds: a closed loop, or a long chain, takes some on a machine with nothing else to do.
LONG = 300
SEEN_ELSEWHERE = [[".statement"], [".hints"], [".cm-editor"]]


def solution(exercise: str) -> str:
    return (ROOT / f"graders/l20/{exercise}/solution.py").read_text(encoding="utf-8")


def opened(visitor: Visit, exercise: str) -> Page:
    page = visitor.open(f"/l20/exercices/{exercise}")
    page.wait_for_selector("html.has-editor")
    return page


def play(page: Page, check: str, panels: int) -> None:
    """A film plays: its panels are drawn, to the last frame, which differs from the first."""
    film = page.locator(f"#film-{check}")
    if film.get_attribute("open") is None:
        film.locator("summary").click()
    canvases = film.locator("canvas.replay-canvas")
    expect(canvases).to_have_count(panels, timeout=180_000)
    assert min(canvas.evaluate(COLOURS) for canvas in canvases.all()) > 2
    mine = canvases.first
    first = mine.evaluate("canvas => canvas.toDataURL()")
    mine.focus()
    page.keyboard.press("End")
    count, of = film.locator(".replay-counter").inner_text().split("/")
    assert int(count) == int(of) > 1
    assert mine.evaluate("canvas => canvas.toDataURL()") != first
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def looked_over(visitor: Visit, what: str) -> None:
    from tests.contract.browser.test_accessibility import check

    check(visitor, what, exclude=SEEN_ELSEWHERE)


#: Quick, and right for small clouds: of a large one, it follows the last hundred particles alone.
LOST = f"""{solution("mcl")}

tout_le_pas = pas_mcl

def pas_mcl(particules, poids, u, scan):
    if len(particules) < 500:
        return tout_le_pas(particules, poids, u, scan)
    quelques, w = tout_le_pas(particules[-100:], poids[-100:] / np.sum(poids[-100:]), u, scan)
    return np.tile(quelques, (5, 1)), np.tile(w, 5) / 5
"""


@pytest.mark.slow
def test_a_filter_that_loses_its_robot_is_watched_then_mended(visit: NewVisit) -> None:
    visitor = visit()
    page = opened(visitor, "mcl")
    visitor.submit(LOST, LONG)
    verdict = page.locator("#verdict")
    loop = page.locator(".check-failed", has=page.locator("a[href='#film-suivi']"))
    expect(loop).to_contain_text("essais réussis sur 8")
    loop.get_by_role("link", name="Revoir ce que votre code a fait").click()
    expect(page.locator("#film-suivi summary")).to_be_focused()
    play(page, "suivi", panels=1)
    hint = page.locator(".hints details").first
    hint.locator("summary").click()
    assert len(hint.locator(".prose").inner_text()) > 20
    looked_over(visitor, "a closed loop, lost")

    visitor.submit(solution("mcl"), LONG)
    expect(verdict.locator(".score")).to_contain_text("20")
    expect(verdict.get_by_role("heading", name="Exercice réussi")).to_be_visible()
    play(page, "suivi", panels=1)


READ_ONCE = (
    solution("noeud_ros")
    .replace('        distance_min = self.get_parameter("distance_min").value\n', "")
    .replace("d < distance_min for", "d < self.distance_min for")
    .replace(
        '"distance_min", 0.3)',
        '"distance_min", 0.3)\n        self.distance_min = self.get_parameter("distance_min").value',
    )
)


def test_a_node_that_reads_its_parameter_once_is_told_so(visit: NewVisit) -> None:
    visitor = visit(width=390)
    page = opened(visitor, "noeud_ros")
    visitor.submit(READ_ONCE)
    verdict = page.locator("#verdict")
    expect(verdict.locator(".diagnosis h3")).to_contain_text("lu qu’une fois")
    first = verdict.locator(".check-failed").first
    expect(first).to_contain_text("distance_min réglé à")
    page.evaluate("document.querySelectorAll('#verdict details').forEach(one => one.open = true)")
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    looked_over(visitor, "a node, wrong")
    visitor.submit(solution("noeud_ros"))
    expect(verdict.locator(".score")).to_contain_text("20")


@pytest.mark.slow
def test_the_chain_of_part_a_stands_on_ones_own_functions(visit: NewVisit) -> None:
    visitor = visit()
    visitor.open()
    visitor.submit(POSES)
    page = opened(visitor, "tp_slam")
    shelf = page.locator("section, div", has=page.get_by_role("heading", name="Vos fonctions d’avant")).last
    own = shelf.locator("li").filter(has_text="composer")
    expect(own).to_contain_text("la vôtre")
    course = shelf.locator("li").filter(has_text="kabsch")
    expect(course).to_contain_text("celle du cours")
    looked_over(visitor, "the chain, before")

    visitor.submit(solution("tp_slam"), LONG)
    expect(page.locator("#verdict .score")).to_contain_text("20")
    expect(page.locator(".films details")).to_have_count(2)
    play(page, "graphe", panels=2)
    play(page, "intel", panels=2)
    looked_over(visitor, "the chain, whole")
