"""Replays in a real browser: all on one page, played and changed by mouse and keys, in both themes, without a fault."""

from __future__ import annotations

import re

import pytest

from server.replays.service import ReplayLibrary
from tests.contract.browser.conftest import NewVisit, Page, Visit, sync_api

expect = sync_api.expect
MOVES = True  # what is played is played as it is for who asks for nothing
HEAD = '<meta charset="utf-8"><title>Essai</title><meta name="viewport" content="width=device-width">'
PIXELS = """canvas => {
  const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  return new Uint32Array(context.getImageData(0, 0, copy.width, copy.height).data.buffer);
}"""
COLOURS = f"canvas => new Set(({PIXELS})(canvas)).size"
CORNER = f"canvas => ({PIXELS})(canvas)[2]"
#: How each text of a drawing was last aligned.
WRITTEN = """const { fillText } = CanvasRenderingContext2D.prototype;
window.written = {};
CanvasRenderingContext2D.prototype.fillText = function (words, ...where) {
  window.written[words] = this.textAlign;
  fillText.call(this, words, ...where);
};"""
#: The width that the longest choice of a list takes, with its arrow.
NEEDS = """select => {
  const context = document.createElement("canvas").getContext("2d");
  context.font = getComputedStyle(select).font;
  return 28 + Math.max(...[...select.options].map((one) => context.measureText(one.text).width));
}"""
#: Looked for at each frame: what expects a text looks again after a second or so.
BEGUN = "counter => !counter.textContent.startsWith('1 / ')"


def reading(visitor: Visit, *names: str, module: str = "l20") -> Page:
    """A page that holds these replays and nothing else."""
    visitor.open("/")
    style = visitor.page.locator("link[href$='css/app.css']").get_attribute("href")
    assert style
    scripts = style.replace("css/app.css", "js/")
    figures = "".join(
        f'<figure class="replay" id="rejeu-{name}" data-source="/{module}/rejeux/{name}">'
        '<div class="replay-stage"></div><figcaption><p>Légende.</p></figcaption></figure>'
        for name in names
    )
    script = f'import {{ enhance }} from "{scripts}replays/index.js"; enhance(document);'
    head = f'{HEAD}<link rel="stylesheet" href="{style}"><script src="{scripts}theme.js"></script>'
    body = f'<main class="prose">{figures}</main><script type="module">{script}</script>'
    page = f'<!doctype html><html lang="fr"><head>{head}</head><body>{body}</body></html>'
    visitor.page.route("**/essai", lambda route: route.fulfill(body=page, content_type="text/html"))
    visitor.page.goto(visitor.server.address + "/essai")
    return visitor.page


@pytest.mark.parametrize(
    ("module", "width"),
    [
        ("l20", 390),
        pytest.param("l20", 1280, marks=pytest.mark.slow),
        pytest.param("l19", 390, marks=pytest.mark.slow),
        pytest.param("l19", 1280, marks=pytest.mark.slow),
    ],
)
def test_every_replay_draws_plays_and_follows_the_theme(visit: NewVisit, module: str, width: int) -> None:
    names = ReplayLibrary().replay_names(module)
    page = reading(visit(width=width, color_scheme="light"), *names, module=module)
    for name in names:
        figure = page.locator(f"#rejeu-{name}")
        figure.scroll_into_view_if_needed()
        canvas = figure.locator("canvas.replay-canvas").first
        expect(canvas).to_be_visible()
        expect(figure.locator(".replay-summary p").first).not_to_be_empty()
        expect(canvas).to_have_attribute("aria-label", re.compile(".{100,}"))
        figure.locator(".replay-transport select").select_option("4")
        canvas.focus()
        page.keyboard.press("Home")
        expect(figure.locator(".replay-counter")).to_have_text(re.compile(r"^1 / "))
        page.keyboard.press(" ")
        page.wait_for_function(BEGUN, arg=figure.locator(".replay-counter").element_handle())
        figure.locator(".replay-play").click()
        assert canvas.evaluate(COLOURS) > 3
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    last = page.locator("canvas.replay-canvas").last
    light = last.evaluate(CORNER)
    page.evaluate("document.documentElement.dataset.theme = 'dark'")
    page.wait_for_function(f"([canvas, light]) => ({CORNER})(canvas) !== light", arg=[last.element_handle(), light])


def test_the_robot_is_dragged_and_moved_with_keys(visit: NewVisit) -> None:
    page = reading(visit(width=1280), "lidar")
    canvas, where = page.locator("canvas.replay-canvas"), page.locator(".replay-pose output")
    expect(where).to_contain_text("x = 11,50, y = 8,20")
    box = canvas.bounding_box()
    assert box
    cell = box["width"] / 24
    page.mouse.move(box["x"] + 11.5 * cell, box["y"] + 8.2 * cell)
    page.mouse.down()
    page.mouse.move(box["x"] + 4.5 * cell, box["y"] + 4.2 * cell, steps=12)
    page.mouse.up()
    expect(where).to_contain_text("x = 4,50, y = 4,20")
    expect(page.locator(".replay-summary")).to_contain_text("x = 4,50 et y = 4,20")
    canvas.focus()
    page.keyboard.press("ArrowRight")
    expect(where).to_contain_text("x = 4,75, y = 4,20")
    page.keyboard.press("d")
    expect(where).to_contain_text("θ = 24°")
    page.get_by_role("button", name="Réglages de départ").click()
    expect(where).to_contain_text("x = 11,50, y = 8,20")


LESSONS = {
    "lidar": "localiser", "filtre-grille": "localiser", "mcl": "localiser", "occupation": "cartographier",
    "icp": "slam", "graphe": "slam", "a-etoile": "ros2",
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("width", "height"), [(1280, 900), (390, 844)])
def test_what_one_moves_and_the_drawing_are_seen_together(visit: NewVisit, width: int, height: int) -> None:
    visitor = visit(width=width, height=height)
    for name, lesson in LESSONS.items():
        visitor.open(f"/l20/lire/{lesson}")
        figure = visitor.page.locator(f"#rejeu-{name}")
        figure.evaluate("figure => figure.scrollIntoView()")
        canvas = figure.locator("canvas.replay-canvas")
        expect(canvas).to_be_visible()
        fields = figure.locator(".replay-settings :is(input, select, button):visible")
        assert fields.count() > 0
        for field in fields.all():
            if width < 1280:  # the page scrolls, the drawing stays
                field.evaluate("field => field.scrollIntoView({ block: 'nearest' })")
            else:
                canvas.evaluate("canvas => canvas.scrollIntoView()")
            drawn, moved = canvas.bounding_box(), field.bounding_box()
            assert drawn is not None, name
            assert moved is not None, name
            foot = drawn["y"] + drawn["height"]
            assert -1 < drawn["y"] < foot <= height + 1, name
            assert moved["y"] + moved["height"] <= height + 1, name
            assert width == 1280 or foot <= moved["y"] + 1, name
        assert visitor.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.slow
def test_what_one_expects_stands_beside_what_happens_and_is_kept(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open("/l20/lire/slam")
    figure = page.locator("#rejeu-graphe")
    figure.evaluate("figure => figure.scrollIntoView()")
    asked = figure.locator(".replay-prediction")
    expect(asked).to_contain_text("Que devient la carte")
    expect(asked).not_to_contain_text("7 cases")
    figure.locator(".replay-transport select").select_option("4")
    asked.get_by_label("Meilleure").check()
    asked.get_by_role("button").click()
    expect(asked).to_contain_text("Vous aviez dit : Meilleure")
    expect(asked).not_to_contain_text("Ce qui arrive :")
    expect(figure.get_by_label("Ajouter une fausse fermeture")).to_be_checked()
    expect(asked).to_contain_text("autre chose arrive")
    expect(asked).to_contain_text("L’écart passe de 1,8 à 7 cases")
    expect(figure.locator(".replay-counter")).to_have_text(re.compile(r"^(\d+) / \1$"))
    page.reload()  # a visitor's browser has kept it
    figure.evaluate("figure => figure.scrollIntoView()")
    expect(asked).to_contain_text("Vous aviez dit : Meilleure")
    expect(asked).not_to_contain_text("L’écart passe de 1,8")


@pytest.mark.slow
@pytest.mark.parametrize(("width", "by"), [(1280, "mouse"), (390, "keys")])
def test_a_point_is_placed_and_stands_beside_what_happens(visit: NewVisit, width: int, by: str) -> None:
    visitor = visit(width=width)
    page = visitor.open("/l20/lire/localiser")
    figure = page.locator("#rejeu-banane")
    figure.evaluate("figure => figure.scrollIntoView()")
    asked, canvas = figure.locator(".replay-prediction"), figure.locator("canvas.replay-canvas")
    x, y = asked.get_by_label("x, vers la droite"), asked.get_by_label("y, vers le haut")
    expect(asked).not_to_contain_text("10,14")
    x.focus()  # the scene of the question comes, at its beginning, and what it tells stays hidden
    expect(figure.locator(".replay-settings")).to_contain_text("0,12")
    expect(figure.locator(".replay-summary")).to_be_hidden()
    before = canvas.screenshot()
    if by == "mouse":
        box = canvas.bounding_box()
        assert box

        def place(share: float) -> float:
            canvas.click(position={"x": share * box["width"], "y": box["height"] / 2})
            expect(x).to_have_value(re.compile(r"^\d"))
            return float(x.input_value())

        left, right = place(0.6), place(0.7)
        place(0.6 + 0.1 * (10.3 - left) / (right - left))
    else:
        for key, times in {"ArrowUp": 1, "Shift+ArrowUp": 3}.items():
            for _ in range(times):
                page.keyboard.press(key)
        expect(x).to_have_value("10")
        y.fill("7")  # out of the box
        asked.get_by_role("button").click()
        expect(asked).to_contain_text("Avant de regarder")
        y.fill("0.25")
    assert canvas.screenshot() != before
    figure.locator(".replay-transport select").select_option("4")
    asked.get_by_role("button").click()
    expect(asked).to_contain_text("Vous aviez placé le point en x = 10,")
    expect(asked).not_to_contain_text("10,14")
    expect(asked).to_contain_text("c’est bien vu")
    expect(asked).to_contain_text("en x = 10,14 et y = 0,09")
    expect(figure.locator(".replay-summary")).to_be_visible()
    page.reload()
    figure.evaluate("figure => figure.scrollIntoView()")
    expect(asked).to_contain_text("Vous aviez placé le point en x = 10,")
    expect(asked).not_to_contain_text("10,14")


def test_a_replay_plays_without_an_answer(visit: NewVisit) -> None:
    visitor = visit(width=1280)
    visitor.page.clock.install()
    page = reading(visitor, "graphe")
    figure = page.locator("#rejeu-graphe")
    asked = figure.locator(".replay-prediction")
    expect(asked.get_by_role("radio")).to_have_count(3)
    expect(figure.locator(".replay-summary")).to_be_visible()  # of another scene than the question's
    figure.get_by_label("Ajouter une fausse fermeture").check()
    expect(figure.locator(".replay-summary")).to_be_hidden()  # words and curves would tell what is asked
    expect(figure.locator(".replay-charts")).to_be_hidden()
    expect(figure.get_by_text("Légende.")).to_be_hidden()  # so would the text below
    figure.locator(".replay-transport select").select_option("4")
    figure.get_by_role("button", name="Lecture").click()
    page.clock.fast_forward(60_000)
    expect(figure.locator(".replay-counter")).to_have_text(re.compile(r"^(\d+) / \1$"))
    expect(figure.locator(".replay-summary")).to_be_visible()
    expect(figure.get_by_text("Légende.")).to_be_visible()
    expect(asked.get_by_role("radio")).to_have_count(3)


def test_settings_that_do_not_act_are_hidden_and_no_label_lies_on_a_dot(visit: NewVisit) -> None:
    visitor = visit(width=1280)
    visitor.page.add_init_script(WRITTEN)
    figure = reading(visitor, "laboratoire").locator("#rejeu-laboratoire")
    allowed, poses = (
        figure.get_by_role("slider", name="Boucles acceptées"),
        figure.get_by_role("combobox", name="Poses utilisées"),
    )
    expect(allowed).to_be_visible()
    assert visitor.page.evaluate("written['acceptées au-dessous']") == "left"  # false loops are on the right
    for select in figure.locator(".replay-settings select").all():
        assert select.evaluate(NEEDS) <= select.evaluate("select => select.clientWidth")
    poses.select_option("recalages")
    expect(allowed).to_be_hidden()
    figure.get_by_role("combobox", name="Trajet").select_option("entier")
    expect(poses).to_be_hidden()
    figure.get_by_role("button", name="Réglages de départ").click()
    expect(allowed).to_be_visible()


def test_keys_that_every_keyboard_has_lead_through_the_frames(visit: NewVisit) -> None:
    page = reading(visit(width=1280), "lidar")  # a scene in which arrows move the robot
    counter = page.locator(".replay-counter")
    expect(counter).to_have_text("36 / 36")
    page.locator("canvas.replay-canvas").focus()
    for key, shown in {"r": "1 / 36", "s": "2 / 36", "S": "3 / 36", "p": "2 / 36", "f": "36 / 36"}.items():
        page.keyboard.press(key)
        expect(counter).to_have_text(shown)
    page.locator(".replay-settings input[type=range]").first.focus()
    page.keyboard.press("r")
    expect(counter).to_have_text("1 / 36")
    page.locator(".replay-transport select").focus()
    page.keyboard.press("f")  # in a list of choices a letter looks for a choice
    expect(counter).to_have_text("1 / 36")
    page.get_by_text("Au clavier").click()
    expect(page.locator(".replay-help")).to_contain_text("image suivante")


@pytest.mark.slow
def test_nothing_moves_by_itself_and_nothing_glides_when_motion_is_not_wanted(visit: NewVisit) -> None:
    page = reading(visit(reduced_motion="reduce"), "lidar")
    expect(page.locator(".replay-counter")).to_have_text("36 / 36")
    page.locator("canvas.replay-canvas").focus()
    page.keyboard.press("Home")
    page.keyboard.press(" ")
    expect(page.locator(".replay-counter")).to_have_text("36 / 36")


@pytest.mark.slow
def test_a_server_that_fails_is_said_and_can_be_asked_again(visit: NewVisit) -> None:
    visitor = visit(expected="500")
    refuse = {"yes": True}

    def answer(route: sync_api.Route) -> None:
        if refuse["yes"]:
            route.fulfill(status=500, body="panne", content_type="text/html")
        else:
            route.continue_()

    visitor.page.route("**/l20/rejeux/lidar", answer)
    page = reading(visitor, "lidar")
    expect(page.locator(".replay-status")).to_contain_text("n’a pas pu être chargée")
    refuse["yes"] = False
    page.get_by_role("button", name="Réessayer").click()
    expect(page.locator("canvas.replay-canvas")).to_be_visible()
    expect(page.locator(".replay-status")).to_be_hidden()
