"""axe finds nothing on any page, in light and in dark, before and after a verdict.

The two themes have the same markup: every rule runs in light, those on colours run again in dark, where mathematics
has the colour of the text around it. A page to read is checked by `test_reading`, which opens one.
"""

from __future__ import annotations

from typing import Any

import pytest

from tests.contract.browser.conftest import EXERCISE, NewVisit, Visit
from tests.contract.browser.test_story import SOLUTION, WRONG

axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed")


AXE = axe.Axe().axe_script
EVERYTHING = {"resultTypes": ["violations"]}
COLOURS = {**EVERYTHING, "runOnly": {"type": "rule", "values": ["color-contrast", "link-in-text-block"]}}
RUN = "([exclude, options]) => axe.run({exclude}, options).then((found) => found.violations)"
#: axe does not read the MathML in a formula, a screen reader does: a page's thousands are taken for their TeX.
FORMULAS = """document.querySelectorAll('.katex:has(annotation)').forEach(one => {
  one.drawn = [...one.childNodes]; one.textContent = one.querySelector('annotation').textContent })"""
DRAWN = "document.querySelectorAll('.katex').forEach(one => one.drawn && one.replaceChildren(...one.drawn))"
CHECKED_ONCE = [[".statement"], [".katex"]]  # what a verdict does not change
#: Most of axe's time goes to contrasts, which it works out again for each of a thousand words that look the same. It is
#: shown the first and the last of those that have the same ink on the same grounds: what an element is written with,
#: and each of those around it that paints, fades or moves something.
ALIKE = """(exclude) => {
  const looks = new Map(), grounds = new Map()
  const paints = (style) => style.backgroundImage !== 'none' || !/^rgba\\(.*, 0\\)$/.test(style.backgroundColor)
    || style.opacity !== '1' || style.filter !== 'none' || style.mixBlendMode !== 'normal'
    || style.position !== 'static' || style.transform !== 'none' || style.float !== 'none'
  const ground = (one) => {
    if (!one) return ''
    if (!grounds.has(one)) {
      const style = getComputedStyle(one), around = ground(one.parentElement)
      grounds.set(one, !paints(style) ? around : [around, style.backgroundImage, style.backgroundColor, style.opacity,
        style.filter, style.mixBlendMode, style.position, style.zIndex, style.transform, style.float].join('|'))
    }
    return grounds.get(one)
  }
  for (const one of document.querySelectorAll('*')) {
    one.removeAttribute('data-contrast')
    if (exclude.some((selector) => one.closest(selector))) continue
    const ink = getComputedStyle(one)
    const look = [ink.color, ink.fontSize, ink.fontWeight, ink.textShadow, ink.webkitTextStroke, ink.visibility,
      ...['::before', '::after'].map((part) => getComputedStyle(one, part)).map((style) =>
        style.content === 'none' ? '' : [style.backgroundColor, style.position, style.opacity].join()),
      one.localName, one.disabled, one.ariaDisabled, ground(one)].join('|')
    looks.set(look, [...(looks.get(look) ?? [one]).slice(0, 1), one])
  }
  for (const some of looks.values()) some.forEach((one) => one.setAttribute('data-contrast', ''))
  axe.configure({rules: [{id: 'color-contrast', selector: '[data-contrast]'}]})
}"""


def check(visitor: Visit, what: str, *, exclude: list[list[str]] | None = None, formulas: bool = False) -> None:
    """With `formulas`, they are looked at too as they are drawn."""
    check_page(visitor.page, what, exclude=exclude, formulas=formulas)


def check_page(page: Any, what: str, *, exclude: list[list[str]] | None = None, formulas: bool = False) -> None:
    if not formulas:
        page.evaluate(FORMULAS)
    page.evaluate(AXE)
    told = []
    for scheme, options, left_out in (("light", EVERYTHING, []), ("dark", COLOURS, [[".katex"]])):
        page.emulate_media(color_scheme=scheme)
        left = (exclude or []) + left_out
        page.evaluate(ALIKE, [selector for (selector,) in left])
        told += [(scheme, *one) for one in faults(page.evaluate(RUN, [left, options]))]
    page.evaluate(DRAWN)
    assert told == [], what


def faults(violations: list[dict[str, Any]]) -> list[tuple[str, str, str]]:
    return [(rule["id"], node["html"][:160], node["failureSummary"]) for rule in violations for node in rule["nodes"]]


#: What hides among hundreds of words that look the same, each with a fault of contrast.
HIDDEN = {
    "ink": "<span class=fault-ink style='color: #999'>mot</span>",
    "ground": "<span style='background: #555'><em class=fault-ground>mot</em></span>",
    "both": "<div style='background: #ddd'><p style='color: #888'><b class=fault-both>mot</b></p></div>",
    "faded": "<div style='opacity: .4'><p class=fault-faded>mot</p></div>",
    "smaller": "<span style='color: #8a8a8a; font-size: 12px' class=fault-smaller>mot</span>",
    "field": "<input aria-label=mot class=fault-field value=mot style='color: #aaa'>",
}


def test_no_fault_of_contrast_hides_among_what_looks_the_same(visit: NewVisit) -> None:
    page = visit().page
    words = "<p>mot <span>mot</span> <em>mot</em> <b>mot</b></p>" * 20
    large = "<span style='color: #8a8a8a; font-size: 32px'>mot</span>" * 3
    among = large.join(["", *HIDDEN.values(), ""])
    page.set_content(f"<body style='color: #333; background: #fff'>{words}{among}{words}")
    page.evaluate(AXE)
    page.evaluate(ALIKE, [])
    assert page.locator("[data-contrast]").count() < 60
    (found,) = page.evaluate(RUN, [[], {"runOnly": ["color-contrast"]}])
    for hidden in HIDDEN:
        assert sum(f"fault-{hidden}" in node["html"] for node in found["nodes"]) == 1, hidden
    assert len(found["nodes"]) == len(HIDDEN)


def test_an_exercise_with_a_wrong_answer(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    visitor.submit("print('bonjour')\n" + WRONG)
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    check(visitor, "exercise, wrong", formulas=True)


@pytest.mark.slow
def test_an_exercise_fresh_and_right(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open()
    check(visitor, "exercise, fresh", formulas=True)
    visitor.submit(SOLUTION)
    attempt = page.locator(".attempts a").first.get_attribute("href")
    page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    check(visitor, "exercise, right", exclude=CHECKED_ONCE)
    page.goto(visitor.server.address + str(attempt))
    check(visitor, "attempt")


@pytest.mark.slow
def test_plain_pages(visit: NewVisit) -> None:
    visitor = visit(expected="404")
    for path in (
        "/",
        f"{EXERCISE}/essais",
        "/connexion",
        "/inscription",
        "/compte",
        "/docs",
        "/donnees-personnelles",
        "/nulle-part",
    ):
        visitor.page.goto(visitor.server.address + path)
        check(visitor, path)


@pytest.mark.slow
def test_pages_of_an_account(visit: NewVisit) -> None:
    visitor = visit(expected="422")
    page = visitor.page
    page.goto(visitor.server.address + "/inscription")
    for field, text in {"name": "Ada", "login": "ada-axe", "password": "notes sur la machine"}.items():
        page.fill(f"#{field}", text)
    page.get_by_role("button", name="Créer le compte").click()
    page.goto(visitor.server.address + "/compte")
    page.fill("#label", "portable")
    page.get_by_role("button", name="Créer un jeton").click()
    check(visitor, "account with a token")
    page.fill("#password", "au hasard")
    page.fill("#new_password", "motdepasse")
    page.get_by_role("button", name="Changer de mot de passe").click()
    check(visitor, "account, refused")
    page.goto(visitor.server.address + "/compte/supprimer")
    check(visitor, "erasure")


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        "/l20", "/l20/glossaire", "/l20/recherche?q=poids", "/l20/lire/recherche", "/l20/lire/exercices-corriges",
        "/l19", "/l19/lire/kalman", "/l19/lire/formules", "/l19/lire/notations",
    ],
)  # fmt: skip
def test_more_pages_to_read(visit: NewVisit, path: str) -> None:
    visitor = visit()
    visitor.page.goto(visitor.server.address + path)
    visitor.page.evaluate("document.querySelectorAll('details').forEach(one => one.open = true)")
    check(visitor, path)


@pytest.mark.slow
def test_pages_of_a_teacher(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.page
    page.goto(visitor.server.teacher_link)
    check(visitor, "welcome")
    page.get_by_label("Nom affiché").fill("Mme Martin")
    page.get_by_label("Identifiant").fill("mme.martin")  # not the login of the demonstration on this server
    page.get_by_label("Mot de passe").fill("une phrase assez longue")
    page.locator("main form button").click()
    visitor.open()
    page.get_by_role("button", name="Ouvrir le corrigé à tous les élèves").click()
    page.wait_for_selector("html.has-editor")
    page.locator("#corrige summary").click()
    check(visitor, "exercise, teacher", exclude=CHECKED_ONCE)
    page.goto(visitor.server.address + "/compte")
    check(visitor, "account")
