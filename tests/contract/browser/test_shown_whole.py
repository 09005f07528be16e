"""Nothing of a course is hidden at the side: each formula, code, comment and table of every page, at every width.

The fast suite looks at one page in four, the thorough run at all.

One page in one browser, whose window is made narrower and wider; 640 and 320 pixels are also 1280 and 640 at 200 %.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import pytest

from server.web.views import exercise_href, lesson_href
from tests.contract.browser.conftest import Browser
from tests.support.chromium import chromium
from tests.support.quick import the_course
from tests.support.served import Server

#: From the widest. What fits at 320 pixels fits at 390, and what fits beside an editor at 1024 fits at 1280: the suite
#: tries the narrowest of each arrangement, a thorough run all.
WIDTHS, ALL_WIDTHS = (1024, 320), (1920, 1366, 1280, 1024, 768, 640, 390, 320)
PHONE = 400
#: Where a table of many columns has no room: on a phone, and beside the editor.
TABLES_SCROLL_UNDER = 1300
#: Formulas that are one bracket or fraction, which nothing cuts: on a phone they scroll.
MAX_FORMULAS_ON_A_PHONE = 10

HIDDEN = """() => {
  const found = [], root = document.documentElement
  if (root.scrollWidth > root.clientWidth) found.push(["page", "", root.scrollWidth - root.clientWidth, true])
  for (const e of document.querySelectorAll("main :is(div, pre, span.katex-wide, textarea, table, figure, section)")) {
    if (!e.clientWidth || e.scrollWidth <= e.clientWidth + 1) continue
    const style = getComputedStyle(e)
    if (style.overflowX === "visible" || style.clipPath !== "none" || e.closest(".visually-hidden")) continue
    const kind = e.matches(".table-scroll") ? "table" : e.matches(".math-display, .katex-wide") ? "formula" : e.tagName
    const signed = style.overflowX === "auto" && style.backgroundAttachment.includes("local") && e.tabIndex === 0
    found.push([kind, e.textContent.trim().slice(0, 60), e.scrollWidth - e.clientWidth, signed])
  }
  return found
}"""


def addresses(step: int) -> list[str]:
    modules = the_course().modules.values()
    lessons = [lesson_href(lesson) for module in modules for lesson in module.lessons if not lesson.solution]
    exercises = [exercise_href(exercise) for module in modules for exercise in module.exercises]
    return [*lessons[::step], *exercises[::step]]


@pytest.mark.skipif(chromium() is None, reason="no Chromium on this machine")
@pytest.mark.parametrize(
    ("widths", "step"), [(WIDTHS, 4), pytest.param(ALL_WIDTHS, 1, marks=pytest.mark.slow)], ids=["some", "all"]
)
def test_nothing_is_hidden_at_the_side(browser: Browser, server: Server, widths: Sequence[int], step: int) -> None:
    context = browser.new_context(java_script_enabled=False, locale="fr-FR", bypass_csp=True)
    page = context.new_page()
    page.set_default_timeout(180_000)
    network = context.new_cdp_session(page)  # nothing is asked of this process for each picture
    network.send("Network.enable")
    network.send("Network.setBlockedURLs", {"urls": ["*.svg*", "*.png*", "*.js*"]})
    hidden: list[tuple[str, int, Any]] = []
    formulas: Counter[int] = Counter()
    for address in addresses(step):
        page.set_viewport_size({"width": widths[0], "height": 900})
        page.goto(server.address + address, wait_until="load")
        page.evaluate("document.fonts.ready.then(() => true)")
        page.evaluate("document.querySelectorAll('main details').forEach(d => d.open = true)")
        for width in widths:
            page.set_viewport_size({"width": width, "height": 900})
            for kind, text, over, signed in page.evaluate(HIDDEN):
                if kind == "formula" and width < PHONE and signed:
                    formulas[width] += 1
                elif not (kind == "table" and width < TABLES_SCROLL_UNDER and signed):
                    hidden.append((address, width, (kind, text, over)))
    context.close()
    assert hidden == []
    assert max(formulas.values(), default=0) <= MAX_FORMULAS_ON_A_PHONE
