"""What a screen reader is given, read from the browser's own tree: names, headings, landmarks, who speaks and when."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import pytest

from tests.contract.browser.conftest import NewVisit, Page, Visit, sync_api

expect = sync_api.expect

CONTROLS = {"button", "link", "textbox", "searchbox", "slider", "spinbutton", "combobox", "checkbox", "radio", "image"}
#: Of which a list is worth reading: two of the same name do the same thing.
ALONE = ("Exécuter la cellule", "Modifier la cellule", "Agrandir la figure")
LANDMARKS = {"banner": 1, "main": 1, "contentinfo": 1}
SPEAKING = "[aria-live]:not([aria-live=off]), [role=status], [role=alert], [role=log]"
#: Notes what is said, and by whom: the same words in two places would be read twice.
LISTEN = f"""() => {{
  window.spoken = [];
  new MutationObserver((changes) => {{
    for (const {{ target }} of changes) {{
      const place = (target.nodeType === 1 ? target : target.parentElement)?.closest('{SPEAKING}');
      const words = place?.textContent.trim().replace(/\\s+/g, ' ');
      if (words) window.spoken.push([place.id || place.className, words]);
    }}
  }}).observe(document.body, {{ subtree: true, childList: true, characterData: true }});
}}"""
LEVELS = """[...document.querySelectorAll('h1, h2, h3, h4, h5, h6')]
  .filter((one) => one.checkVisibility()).map((one) => +one.tagName[1])"""


@dataclass(frozen=True)
class Node:
    role: str
    name: str
    properties: dict[str, Any]
    children: list[Node] = field(default_factory=list)


def nodes(page: Page) -> list[Node]:
    """Those that are not ignored, in no order; the children of a formula too."""
    raw = page.context.new_cdp_session(page).send("Accessibility.getFullAXTree")["nodes"]
    made = {one["nodeId"]: _node(one) for one in raw}
    for one in raw:
        made[one["nodeId"]].children.extend(made[child] for child in one.get("childIds", []) if child in made)
    return [made[one["nodeId"]] for one in raw if not one.get("ignored")]


def _node(raw: dict[str, Any]) -> Node:
    said = {one["name"]: one["value"].get("value") for one in raw.get("properties", [])}
    return Node(raw.get("role", {}).get("value", ""), raw.get("name", {}).get("value", "").strip(), said)


def check(visitor: Visit, path: str, button: str = "") -> list[Node]:
    """The tree of a page, once its scripts have made that button."""
    page = visitor.open(path)
    page.wait_for_load_state("load")
    if button:
        expect(page.get_by_role("button", name=button)).to_be_visible()
    tree = nodes(page)
    assert [one.role for one in tree if one.role in CONTROLS and not one.name] == [], path
    roles = Counter(one.role for one in tree)
    assert {role: roles[role] for role in LANDMARKS} == LANDMARKS, path
    ways = [one.name for one in tree if one.role == "navigation"]
    assert all(ways), path
    assert len(ways) == len(set(ways)), path
    levels = page.evaluate(LEVELS)
    assert levels.count(1) == 1, path
    assert [(a, b) for a, b in pairwise(levels) if b - a > 1] == [], path
    names = Counter(one.name for one in tree if one.role == "button" and one.name.startswith(ALONE))
    assert [name for name, times in names.items() if times > 1] == [], path
    assert all(one.children for one in tree if one.role == "MathMLMath"), f"{path}: formulas are said by their MathML"
    return tree


def test_a_lesson(visit: NewVisit) -> None:
    visitor = visit()
    check(visitor, "/l20/lire/methodes", "Exécuter la cellule 2")
    page = visitor.page
    page.evaluate(LISTEN)
    page.get_by_role("button", name="Exécuter la cellule 1").click()
    expect(page.locator(".cell-output").first).to_contain_text("moyenne circulaire")
    said = page.evaluate("window.spoken")
    assert {place for place, _ in said} == {"cell-output"}
    assert "différence brute" in said[-1][1]


@pytest.mark.slow
def test_a_verdict_is_said_once(visit: NewVisit) -> None:
    visitor = visit()
    check(visitor, "/l20/exercices/calcul_logodds")
    page = visitor.page
    page.evaluate(LISTEN)
    page.locator("#essai input:not([type=hidden])").first.fill("1,5")
    page.locator("#envoyer").click()
    visitor.verdict()
    expect(page.locator("#annonce")).to_contain_text("Verdict")
    verdicts = [words for _, words in page.evaluate("window.spoken") if "sur 20" in words]
    assert len(set(verdicts)) == 1
    assert {place for place, words in page.evaluate("window.spoken") if "sur 20" in words} == {"annonce"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/l20",
        "/l20/glossaire",
        "/l20/lire/localiser",
        "/l20/lire/slam",
        "/l20/lire/epreuve",
        "/l20/lire/epreuve-corrige",
        "/l20/exercices/poses",
        "/l20/exercices/demo_1",
        "/l20/exercices/verification",
    ],
)
def test_every_kind_of_page(visit: NewVisit, path: str) -> None:
    check(visit(width=390), path)
