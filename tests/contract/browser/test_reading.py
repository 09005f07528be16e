"""Reading in a real browser: words that explain themselves, what has been read, the search, the paper."""

from __future__ import annotations

import pytest

from tests.contract.browser.conftest import NewVisit, Page, Visit, sync_api
from tests.contract.browser.test_accessibility import check

expect = sync_api.expect
READ = "/l20/lire/localiser"
#: The page prints what it has after twenty seconds, which a busy machine may need for one drawing.
WITHOUT_LIMIT = """(() => { const wait = window.setTimeout
  window.setTimeout = (then, delay, ...rest) => delay >= 20000 ? 0 : wait(then, delay, ...rest) })()"""
#: The inks of the body and of each paragraph, just after a click on the button: nothing is painted yet.
CLICKED = """() => { document.getElementById('theme').click()
  const all = [document.body, ...document.querySelectorAll('.reading-body > p')]
  return all.map((one) => getComputedStyle(one).color) }"""
INKS = "[...new Set([...document.querySelectorAll('.reading-body > p')].map((one) => getComputedStyle(one).color))]"
SETTLED = "() => document.documentElement.dataset.theme && !document.querySelector('body[data-theme], [data-kept]')"


def test_a_page_is_read_in_one_visit(visit: NewVisit) -> None:
    """One story, as opening a page of so many formulas takes longer than each of its parts."""
    visitor = visit(color_scheme="light")
    visitor.open(READ)
    words_show_their_definitions(visitor)
    what_is_in_sight_takes_a_theme_first(visitor.page)
    what_has_been_read_is_remembered(visitor)


def words_show_their_definitions(visitor: Visit) -> None:
    """axe finds nothing on the page, with one of them shown and all that is folded open."""
    page = visitor.page
    page.evaluate("document.querySelectorAll('details').forEach((block) => { block.open = true })")
    word, definition = page.locator(".term").first, page.get_by_role("tooltip")
    word.focus()
    expect(definition).to_be_visible()
    assert word.get_attribute("aria-describedby") == definition.get_attribute("id")
    check(visitor, READ)
    page.emulate_media(color_scheme="light")
    page.keyboard.press("Escape")
    expect(definition).to_be_hidden()
    page.locator(".term").nth(1).hover()
    expect(definition).to_be_visible()
    definition.hover()
    page.wait_for_timeout(400)
    expect(definition).to_be_visible()
    page.locator("h1").hover()
    expect(definition).to_be_hidden()


def what_is_in_sight_takes_a_theme_first(page: Page) -> None:
    """And all of the page after it."""
    ink = page.evaluate("getComputedStyle(document.body).color")
    for theme in ("dark", "light", "dark"):
        body, *blocks = page.evaluate(CLICKED)
        assert body != ink
        assert {blocks[0], blocks[-1]} == {body, ink}, "the first is in sight, the last is not"
        page.wait_for_function(SETTLED)
        assert page.evaluate("document.documentElement.dataset.theme") == theme
        ink = page.evaluate("getComputedStyle(document.body).color")
        assert page.evaluate(INKS) == [ink]
    page.evaluate(f"() => {{ ({CLICKED})(); ({CLICKED})() }}")  # twice before anything is painted
    page.wait_for_function(SETTLED)
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"


def what_has_been_read_is_remembered(visitor: Visit) -> None:
    page = visitor.page
    contents = page.get_by_role("navigation", name="Sommaire de la page", exact=True)
    contents.get_by_role("link").nth(2).click()
    expect(contents.locator("[aria-current=location]")).to_have_count(1)
    page.get_by_role("button", name="Tout marquer comme lu").click()
    expect(page.locator(".read-state")).to_contain_text("Vous avez lu toute cette page.")
    page.goto(visitor.server.address + "/l20")
    expect(page.locator("[data-read-of=localiser]")).to_have_text("lue en entier")
    expect(page.locator("[data-start]")).to_have_text("Continuer : Séance 2")
    page.locator("[data-start]").click()
    page.wait_for_url("**/l20/lire/cartographier")


@pytest.mark.slow
def test_a_finger_sees_the_definition_before_it_leaves_the_page(visit: NewVisit) -> None:
    visitor = visit(width=390, height=844, has_touch=True)
    page = visitor.open(READ)
    word = page.locator(".term").first
    word.tap()
    expect(page.get_by_role("tooltip")).to_be_visible()
    assert page.url.endswith(READ)
    word.tap()
    page.wait_for_url("**/l20/glossaire#t-*")


def test_a_slash_leads_to_the_search_and_a_hit_to_its_passage(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open("/l20")
    page.keyboard.press("/")
    page.keyboard.type("particule")
    page.keyboard.press("Enter")
    page.wait_for_url("**/l20/recherche?q=particule")
    expect(page.locator("mark").first).to_be_visible()
    page.locator(".hits a[href*='/lire/'][href*='#']").first.click()
    expect(page.locator("h2:target, h3:target, h4:target")).to_be_visible()


def test_nothing_moves_on_a_page_but_pictures_in_sight_that_are_awaited(visit: NewVisit) -> None:
    visitor = visit(reduced_motion="no-preference")
    held: list[object] = []
    visitor.page.route("**/figures/**", lambda route: held.append(route))  # noqa: PLW0108
    page = visitor.open(READ)
    moving = "document.getAnimations().map((one) => one.effect.target.getBoundingClientRect().top)"
    assert page.locator(".drawing img").count() > 2
    assert page.evaluate(moving) == []
    page.locator(".drawing img:visible").first.scroll_into_view_if_needed()
    page.wait_for_function("() => document.getAnimations().length > 0")
    assert all(-2000 < top < page.viewport_size["height"] for top in page.evaluate(moving))
    assert held


def test_the_button_fetches_every_drawing_before_it_prints(visit: NewVisit) -> None:
    visitor = visit(color_scheme="dark")
    visitor.page.add_init_script(WITHOUT_LIMIT)
    page = visitor.open("/l20/lire/formules")
    page.evaluate("() => { window.print = () => { window.printed = true } }")
    page.get_by_role("button", name="Imprimer").click()
    page.wait_for_function("() => window.printed", timeout=180_000)
    assert page.locator(".figure-light").evaluate_all("images => images.every(one => one.naturalWidth > 0)")


@pytest.mark.parametrize("script", [True, pytest.param(False, marks=pytest.mark.slow)])
def test_on_paper_everything_is_unfolded_and_nothing_is_dark(visit: NewVisit, script: bool) -> None:
    visitor = visit(color_scheme="dark", java_script_enabled=script)
    page = visitor.open("/l20/lire/exercices-corriges")
    page.emulate_media(media="print")
    if script:
        page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    for one in (".site-head", ".contents-side", ".page-turn", ".figure-dark"):
        assert page.locator(f"{one}:visible").count() == 0, one
    height = "details => details.querySelector('summary').nextElementSibling.nextElementSibling.offsetHeight"
    for details in page.locator("details.block-correction").all():
        assert details.evaluate(height) > 10
    assert len(page.pdf(prefer_css_page_size=True)) > 20_000


@pytest.mark.slow
def test_a_question_is_marked_where_it_stands(visit: NewVisit) -> None:
    page = visit(width=390).open("/l20/lire/localiser")
    asked = page.locator("#question-verification-odometrie")
    asked.get_by_role("button", name="Vérifier").click()
    expect(asked.get_by_role("status")).to_contain_text("Choisissez d’abord")
    asked.get_by_label("Elle est fausse de quelques").check()
    asked.get_by_role("button", name="Vérifier").click()
    expect(asked.get_by_role("status")).to_contain_text("Pas encore")
    expect(asked.get_by_role("status")).to_contain_text("ne la bornent pas")
    asked.get_by_label("Elle est précise d’un instant").check()
    expect(asked.get_by_role("status")).to_be_empty()
    page.keyboard.press("Enter")
    expect(asked.get_by_role("status")).to_contain_text("Juste")
