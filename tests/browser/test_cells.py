"""A runnable cell in a real browser: run, changed, wrong, given back."""

from __future__ import annotations

from tests.browser.conftest import NewVisit, Page, sync_api

expect = sync_api.expect
CELL = """<section class="cell" id="cellule-essai" data-name="essai" data-action="/l20/cellules"><div class="cell-code">
<pre class="code" tabindex="0"><code>import matplotlib.pyplot as plt
<span class="nb">print</span>("bonjour", H * W)
plt.plot(lidar((3, 3, 0)))
</code></pre></div></section>"""
#: Until a page of the course has one, a cell is put into a page by hand.
ENHANCE = """async (cell) => {
  document.querySelector("main").insertAdjacentHTML("beforeend", cell);
  const scripts = document.querySelector("script[type=module][src*='/static/']").src;
  const { enhance } = await import(new URL("cells.js", scripts).href);
  enhance(document);
}"""


def opened(page: Page) -> sync_api.Locator:
    page.evaluate(ENHANCE, CELL)
    return page.locator("#cellule-essai")


def test_a_cell_is_run_changed_marked_and_given_back(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open("/l20")
    cell = opened(page)
    assert page.locator(".cm-content").count() == 0, "the editor waits until it is wanted"
    cell.get_by_role("button", name="Exécuter").click()
    output = cell.get_by_role("log")
    expect(output).to_contain_text("bonjour 384")
    picture = output.get_by_role("img", name="Figure produite par la cellule essai")
    expect(picture).to_be_visible()
    page.wait_for_function("image => image.complete && image.naturalWidth > 300", arg=picture.element_handle())
    expect(cell.locator(".cell-time")).to_contain_text(" s")

    cell.get_by_role("button", name="Modifier").click()
    visitor.write("print('<b>avant</b>')\n1 / 0")
    page.keyboard.press("Control+Enter")
    expect(output.locator("pre")).to_have_text("<b>avant</b>\n")
    expect(output).to_contain_text("Un diviseur est nul")
    expect(page.locator(".cm-faultLine")).to_have_text("1 / 0")

    page.reload()
    cell = opened(page)
    expect(cell.locator("pre.code")).to_contain_text("1 / 0")
    cell.get_by_role("button", name="Rétablir").click()
    expect(cell.locator("pre.code")).to_contain_text("bonjour")
    expect(cell.get_by_role("button", name="Rétablir")).to_be_hidden()
    page.reload()
    expect(opened(page).locator("pre.code")).to_contain_text("bonjour")
