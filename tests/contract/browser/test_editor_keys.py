"""The keys of an exercise's editor: the bar that a phone has, and the key that goes to the verdict."""

from __future__ import annotations

from tests.contract.browser.conftest import NewVisit, sync_api

expect = sync_api.expect


def test_a_phone_has_a_bar_of_keys_above_its_keyboard(visit: NewVisit) -> None:
    page = visit(width=390, height=844, has_touch=True, is_mobile=True).open()
    bar = page.get_by_role("group", name="Touches pour le code")
    code, lines = page.locator(".cm-content"), page.locator(".cm-line")

    def press(*names: str) -> None:
        for name in names:
            bar.get_by_role("button", name=name, exact=True).tap()

    expect(bar).to_be_visible()
    code.tap()
    page.keyboard.press("Control+a")
    page.keyboard.press("Delete")
    page.keyboard.insert_text("f")
    press("Parenthèses", "Crochets", "Caractère suivant", "Caractère suivant", "Deux-points")
    expect(lines).to_have_text(["f([]):"])
    expect(code).to_be_focused()
    page.keyboard.press("Enter")
    page.keyboard.insert_text("x")
    press("Désindenter", "Indenter", "Égal", "Guillemets")
    expect(lines).to_have_text(["f([]):", '    x=""'])
    press("Ligne du dessus", "Caractère précédent", "Tiret bas")
    expect(lines.first).to_contain_text("_")
    press("Annuler la dernière frappe")
    expect(lines).to_have_text(["f([]):", '    x=""'])

    foot = "bar => [getComputedStyle(bar).position, Math.round(bar.getBoundingClientRect().bottom)]"
    assert bar.evaluate(foot) == ["fixed", 844], "while one writes it is at the foot of what is seen"
    for button in bar.get_by_role("button").all():
        size = button.bounding_box()
        assert size is not None
        assert min(size["width"], size["height"]) >= 40
    page.evaluate("document.activeElement.blur()")
    expect(bar).to_have_css("position", "static")
    assert page.evaluate("document.documentElement.scrollWidth") <= 390


def test_a_key_goes_to_the_verdict_which_is_announced_and_comes_back(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    expect(page.get_by_role("group", name="Touches pour le code")).to_have_count(0)
    page.locator(".cm-content").click()
    page.keyboard.press("Control+Shift+Enter")
    expect(page.get_by_role("status")).to_contain_text("Pas encore de verdict")
    expect(page.locator(".cm-content")).to_be_focused()
    visitor.submit("def composer(a, b):\n    return [1 / 1, 2, 3]\n")
    title = page.locator("#titre-verdict")
    expect(page.get_by_role("status")).to_contain_text("sur 20")
    page.keyboard.press("Control+Shift+Enter")
    expect(title).to_be_focused()
    expect(title).to_be_in_viewport()
    page.keyboard.press("Control+Shift+Enter")
    expect(page.locator(".cm-content")).to_be_focused()
