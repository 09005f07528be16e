"""Manipulations in a real browser: moved by mouse, by finger and with the keys, told aloud, and quick enough."""

from __future__ import annotations

import json
import re

import pytest

from server.replays.service import ReplayLibrary
from tests.contract.browser.conftest import NewVisit, Page, Visit, sync_api
from tests.contract.browser.test_replays import COLOURS, HEAD

pytestmark = pytest.mark.slow
expect = sync_api.expect
MOVES = True  # what is played is played as it is for who asks for nothing
Locator = sync_api.Locator
NAMES = ReplayLibrary().manipulation_names("l20")
WHERE = {
    "ressorts": "slam",
    "elastique": "theoremes",
    "passant": "telemetre",
    "particules": "localiser",
    "carte": "localiser",
    "gain": "filtre-bayesien",
    "faisceau": "telemetre",
}
INSIDE = """figure => [...figure.querySelectorAll("table, button")].every(
  (one) => one.getBoundingClientRect().right <= figure.getBoundingClientRect().right,
)"""
SAID = ".hands-said"


def figure(visitor: Visit, name: str) -> Locator:
    """A page that holds this manipulation and nothing else, ready."""
    visitor.open("/")
    style = visitor.page.locator("link[href$='css/app.css']").get_attribute("href")
    assert style
    scripts = style.replace("css/app.css", "js/")
    module = f'import {{ enhance }} from "{scripts}manipulations/index.js"; enhance(document);'
    body = (
        f'<main class="prose"><figure class="replay manipulation" id="manipulation-{name}" '
        f'data-hands="/l20/manipulations/{name}"><div class="replay-stage"></div></figure></main>'
        f'<script type="module">{module}</script>'
    )
    head = f'{HEAD}<link rel="stylesheet" href="{style}"><script src="{scripts}theme.js"></script>'
    page = f'<!doctype html><html lang="fr"><head>{head}</head><body>{body}</body></html>'
    visitor.page.route("**/essai", lambda route: route.fulfill(body=page, content_type="text/html"))
    visitor.page.goto(visitor.server.address + "/essai")
    found = visitor.page.locator(f"#manipulation-{name}[data-ready=yes]")
    expect(found.locator("canvas.replay-canvas").first).to_be_visible()
    return found


def drag(page: Page, handle: Locator, right: float, down: float, steps: int = 12) -> None:
    """By so many pixels; the button stays pressed."""
    box = handle.bounding_box()
    assert box
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + right, y + down, steps=steps)


def total(said: str) -> float:
    found = re.search(r"Somme des χ² : ([\d\s,]+)", said.replace("\u202f", "").replace("\xa0", " "))
    assert found, said
    return float(found[1].strip().replace(",", "."))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("width", [390, 1280])
def test_every_manipulation_fits_and_follows_the_theme(visit: NewVisit, name: str, width: int) -> None:
    found = figure(visit(width=width), name)
    page = found.page
    expect(found.locator(SAID)).not_to_be_empty()
    assert found.locator("canvas.replay-canvas").first.evaluate(COLOURS) > 3
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert found.evaluate(INSIDE)
    for handle in found.get_by_role("slider").all():
        assert handle.get_attribute("aria-valuetext")
    before = found.locator("canvas.replay-canvas").first.screenshot()
    page.evaluate("document.documentElement.dataset.theme = 'dark'")
    page.wait_for_timeout(200)
    assert found.locator("canvas.replay-canvas").first.screenshot() != before


@pytest.mark.parametrize("name", NAMES)
def test_without_scripts_a_drawing_and_its_words_stand_there(visit: NewVisit, name: str) -> None:
    visitor = visit(java_script_enabled=False)
    page = visitor.page
    drawn = "<svg xmlns='http://www.w3.org/2000/svg'/>"  # without scripts, a page asks for all of its pictures at once
    page.route("**/figures/*", lambda route: route.fulfill(body=drawn, content_type="image/svg+xml"))
    visitor.open(f"/l20/lire/{WHERE[name]}")
    found = page.locator(f"#manipulation-{name}")
    found.scroll_into_view_if_needed()
    expect(found.locator("img:visible")).to_have_count(1)
    assert len(found.locator("img:visible").get_attribute("alt") or "") > 60
    expect(found.locator("figcaption")).not_to_be_empty()
    expect(found.locator(".replay-stage")).to_be_hidden()


def test_springs_redden_relax_are_cut_and_tied(visit: NewVisit) -> None:
    found = figure(visit(), "ressorts")
    page, said = found.page, found.locator(SAID)
    found.get_by_role("button", name="Détendre").click()
    expect(said).to_contain_text("12,2")
    drag(page, found.get_by_role("slider", name="Pose 10", exact=True), 0, -40)
    assert total(said.inner_text()) > 500
    page.mouse.up()
    expect(found.locator("[role=status]").last).not_to_be_empty()
    found.get_by_role("button", name="Détendre").click()
    expect(said).to_contain_text("12,2")
    # With the keys: the pose moves, turns, and hands over to its neighbour.
    pose = found.get_by_role("slider", name="Pose 10", exact=True)
    pose.focus()
    told = pose.get_attribute("aria-valuetext")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("g")
    assert pose.get_attribute("aria-valuetext") != told
    assert total(said.inner_text()) > 12.3
    page.keyboard.press("PageDown")
    expect(found.get_by_role("slider", name="Pose 11", exact=True)).to_be_focused()
    # A false closure is tied, bends everything, and a kernel lets it go.
    found.get_by_role("button", name="Nouer").click()
    row = found.get_by_role("row", name=re.compile("6 – 16"))
    found.get_by_label("Noyau des fermetures").select_option("dcs")
    found.get_by_role("button", name="Détendre").click()
    expect(row).to_contain_text("≈")
    found.get_by_role("button", name="Couper la fermeture 6 – 16").click()
    expect(row).to_have_count(0)
    expect(said).to_contain_text("12,2")
    found.get_by_role("button", name="Tout remettre").click()
    assert round(total(said.inner_text())) == 2111


def test_the_others_follow_the_hand(visit: NewVisit) -> None:
    found = figure(visit(), "ressorts")
    page = found.page
    found.get_by_role("button", name="Détendre").click()
    expect(found.locator(SAID)).to_contain_text("12,2")
    found.get_by_label("Les autres poses suivent la main").check()
    neighbour = found.get_by_role("slider", name="Pose 11", exact=True)
    before = neighbour.get_attribute("aria-valuetext")
    drag(page, found.get_by_role("slider", name="Pose 10", exact=True), 30, 30)
    assert neighbour.get_attribute("aria-valuetext") != before
    page.mouse.up()


def test_the_chain_shares_what_is_missing(visit: NewVisit) -> None:
    found = figure(visit(), "elastique")
    page, said = found.page, found.locator(SAID)
    for label, value in (("Maillons n", "100"), ("Écart-type d’un maillon σ", "5")):
        found.get_by_label(label).fill(value)
    expect(said).to_contain_text("la fermeture garde 3,85 cm")
    expect(said).to_contain_text("de 50,0 cm à 9,81 cm")
    flag = found.get_by_role("slider", name="Où la fermeture place la dernière pose")
    drag(page, flag, -60, 30)
    page.mouse.up()
    assert flag.get_attribute("aria-valuetext") != "écart de +1,00 m"
    flag.focus()
    page.keyboard.press("Shift+ArrowRight")
    expect(said).to_contain_text("de 50,0 cm à 9,81 cm")


def test_the_gain_follows_the_spreads_and_the_measurement(visit: NewVisit) -> None:
    found = figure(visit(), "gain")
    page, said = found.page, found.locator(SAID)
    expect(said).to_contain_text("K = 0,83")
    expect(said).to_contain_text("2,6 fois l’erreur de Kalman")
    found.get_by_label("Écart-type de la prédiction").fill("0.2")
    expect(said).to_contain_text("K = 0,14")
    measure = found.get_by_role("slider", name="Mesure", exact=True)
    drag(page, measure, 100, 5)
    page.mouse.up()
    assert measure.get_attribute("aria-valuetext") != "5,6 m"
    measure.focus()
    for _ in range(4):
        page.keyboard.press("Shift+ArrowRight")
    expect(said).to_contain_text("écarts-types de ce qu’on attendait")


def test_a_mixture_is_set_by_hand_and_em_does_better(visit: NewVisit) -> None:
    found = figure(visit(), "faisceau")
    said, table = found.locator(SAID), found.get_by_role("table")
    expect(said).to_contain_text("−858,5")
    found.get_by_label("Largeur du bon écho σ").fill("0.3")
    expect(said).not_to_contain_text("−858,5")
    found.get_by_role("button", name="Réglages de départ").click()
    found.get_by_role("button", name="Un tour d’EM").click()
    expect(table).to_contain_text("−640,3")
    expect(said).to_contain_text("EM en est là après 1 tour")
    found.get_by_role("button", name="Jusqu’au bout").click()
    expect(table).to_contain_text("−609,6")
    expect(found.get_by_role("button", name="Un tour d’EM")).to_be_disabled()
    found.get_by_role("button", name="Revenir à vos réglages").click()
    expect(table).not_to_contain_text("−609,6")
    found.get_by_label("Hasard").fill("0")
    found.get_by_label("Largeur du bon écho σ").fill("0.05")
    expect(said).to_contain_text("impossible")


def test_a_walker_turns_the_gaussian_and_not_the_mixture(visit: NewVisit) -> None:
    found = figure(visit(width=390, has_touch=True), "passant")
    page = found.page
    preferred = found.get_by_role("row", name=re.compile("préférée"))
    expect(preferred).to_contain_text("la vraiela vraie")
    walker = found.get_by_role("slider", name="Passant")
    walker.focus()
    for _ in range(2):
        page.keyboard.press("ArrowLeft")
    expect(preferred).to_contain_text("la faussela vraie")
    expect(found.locator("[role=status]").last).to_contain_text("rayons arrêtés")
    drag(page, walker, 0, -60)
    page.mouse.up()
    expect(found.locator(SAID)).not_to_contain_text("Gaussienne : la fausse")


def test_particles_are_placed_by_touch_or_with_keys_and_the_filter_runs(visit: NewVisit) -> None:
    found = figure(visit(width=390, has_touch=True), "particules")
    page, canvas = found.page, found.locator("canvas.replay-canvas").first
    found.get_by_role("button", name="Lancer le filtre").click()
    expect(found.locator("[role=status]").first).to_contain_text("aucune particule")
    box = canvas.bounding_box()
    assert box
    page.touchscreen.tap(box["x"] + box["width"] * 3.5 / 24, box["y"] + box["height"] * 3.5 / 16)
    expect(found.locator(SAID)).to_contain_text("100 particules en un endroit")
    found.get_by_role("slider", name="Où poser des particules").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    expect(found.locator(SAID)).to_contain_text("200 particules en 2 endroits")
    page.keyboard.press("Backspace")
    found.get_by_role("button", name="Lancer le filtre").click()
    expect(found.locator(".replay-summary")).to_contain_text("Retrouvé")
    expect(found.locator(".replay-counter")).not_to_have_text(re.compile("^1 /"))
    expect(found.locator(".replay-play")).to_be_focused()
    found.get_by_role("button", name="Replacer les particules").click()
    expect(found.locator(SAID)).to_contain_text("100 particules en un endroit")


def test_a_map_is_painted_kept_and_used(visit: NewVisit) -> None:
    visitor = visit()
    found = figure(visitor, "carte")
    page, said = found.page, found.locator(SAID)
    found.get_by_role("button", name="Tout vider").click()
    expect(said).to_contain_text("Aucun mur")
    box = found.locator("canvas.replay-canvas").first.bounding_box()
    assert box
    cell = box["width"] / 18
    page.mouse.move(box["x"] + 5.5 * cell, box["y"] + 6.5 * cell)
    page.mouse.down()
    page.mouse.move(box["x"] + 9.5 * cell, box["y"] + 6.5 * cell, steps=2)
    page.mouse.up()
    expect(said).to_contain_text("5 murs")
    brush = found.get_by_role("slider", name="Pinceau")
    brush.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press(" ")
    expect(said).to_contain_text("6 murs")
    assert brush.get_attribute("aria-valuetext") == "ligne 3, colonne 2\xa0: mur"
    page.reload()
    expect(page.locator(SAID)).to_contain_text("6 murs")
    with page.expect_response(re.compile("lance=1")) as told:
        page.get_by_role("button", name="Lancer le robot").click()
    assert len(json.loads(told.value.text())["frames"]) > 40
    expect(page.locator(".replay-summary")).to_be_visible()
    page.get_by_role("button", name="Retoucher la carte").click()
    expect(page.locator(SAID)).to_contain_text("6 murs")
    page.evaluate("localStorage.setItem('balise-carte-dessinee', '{\"cases\": 3, \"robot\": [1e9]}')")
    page.reload()
    expect(page.locator(SAID)).to_contain_text("23 murs")
