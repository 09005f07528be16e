"""A runnable cell of a lesson in a real browser: run, changed, wrong, given back."""

from __future__ import annotations

import re

from tests.contract.browser.conftest import NewVisit, sync_api

expect = sync_api.expect
LESSON = "/l20/lire/localiser"


def test_a_cell_is_run_changed_marked_and_given_back(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open(LESSON)
    name = page.locator("section.cell", has_text="matplotlib").first.get_attribute("data-name")
    cell = page.locator(f"#cellule-{name}")
    code = cell.locator("pre.code")
    original = code.inner_text()
    assert page.locator(".cm-content").count() == 0, "the editor waits until it is wanted"
    cell.get_by_role("button", name="Exécuter").click()
    output = cell.get_by_role("log")
    picture = output.get_by_role("img", name=f"Figure produite par la cellule {name}").first
    expect(picture).to_be_visible()
    page.wait_for_function("image => image.complete && image.naturalWidth > 300", arg=picture.element_handle())
    expect(cell.locator(".cell-time")).to_have_text(re.compile(r"\d s$"))
    expect(output.locator(".cell-fault")).to_have_count(0)

    code.focus()
    page.keyboard.type("while True: pass #")
    expect(cell.locator(".cm-line").first).to_contain_text("while True: pass #")
    cell.get_by_role("button", name="Exécuter").click()
    cell.get_by_role("button", name="Arrêter").click()
    expect(output).to_have_text("La cellule est arrêtée.")
    expect(cell.get_by_role("button", name="Arrêter")).to_be_hidden()
    visitor.write("print('<b>avant</b>')\n1 / 0")
    page.keyboard.press("Control+Enter")
    expect(output.locator("pre")).to_have_text("<b>avant</b>\n")
    expect(output).to_contain_text("Un diviseur est nul")
    expect(page.locator(".cm-faultLine")).to_have_text("1 / 0")

    page.reload()
    expect(code).to_have_text("print('<b>avant</b>')\n1 / 0")
    cell.get_by_role("button", name="Rétablir").click()
    assert code.inner_text() == original
    expect(cell.get_by_role("button", name="Rétablir")).to_be_hidden()
    page.reload()
    expect(cell.get_by_role("button", name="Exécuter")).to_be_visible()
    assert code.inner_text() == original
