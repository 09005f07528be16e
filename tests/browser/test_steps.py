"""A program step by step in a real browser: gone through by keys, clicks and table; whatever it holds, harmless."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from tests.browser.conftest import NewVisit, Page, Visit, sync_api
from tests.browser.test_accessibility import check
from tests.steps.page_scripts import number, step, trace

expect = sync_api.expect
HOSTILE = "</script><img src=x onerror=alert(1)>"
SOURCE = """def f0(P, n):
    total = 0
    for k in range(n):
        total += f1(k)
    P[1] = total
    return P

def f1(x):
    return 2 * x"""


def points(*values: float, entries: tuple[int, ...] = ()) -> dict[str, Any]:
    texts = [str(one) for one in values]
    return {"kind": "array", "dtype": "float64", "shape": [len(values) // 2, 2], "values": texts, "cut": False, "alias": 1}


def looped() -> dict[str, Any]:
    steps = [step(1, "call", P=points(0, 0, 1, 1), n=3), step(2), step(3, total=0)]
    parents: list[int | None] = [None]
    for k in range(3):
        parents.append(0)
        steps += [step(4, k=k), step(8, "call", k + 1, x=k), step(9, frame=k + 1)]
        steps.append(step(9, "return", k + 1) | {"value": number(2 * k)})
        steps.append(step(3, **({"total": k * (k + 1)} if k else {})))
    changed = step(6, P=points(0, 0, 6, 6))
    changed["changes"][0]["entries"] = [2, 3]
    steps += [step(5), changed, step(6, "return") | {"value": points(0, 0, 6, 6)}]
    data = trace(SOURCE, steps, tuple(parents))
    for frame in data["frames"][1:]:
        frame["function"] = "f1"
    data["end"]["value"] = points(0, 0, 6, 6)
    data["mark"] = {"line": 5, "words": "Une seule ligne change."}
    return data


def opened(visitor: Visit, data: dict[str, Any]) -> Page:
    """A page that shows this trace and nothing else."""
    visitor.open("/connexion")
    style = visitor.page.locator("link[href$='css/app.css']").get_attribute("href")
    assert style
    script = style.replace("css/app.css", "js/steps/index.js")
    visitor.page.evaluate(f"data => import('{script}').then(({{ show }}) => show(data))", json.loads(json.dumps(data)))
    expect(visitor.page.locator("dialog.stepping")).to_be_visible()
    return visitor.page


def test_one_goes_through_a_program_by_keys_clicks_and_laps(visit: NewVisit) -> None:
    page = opened(visit(), looped())
    counter, status = page.locator(".steps-counter"), page.locator(".steps-status")
    following = page.locator(".steps-next .steps-number")
    expect(counter).to_have_text("1 / 12")
    expect(status).to_have_text("Appel de f0, qui reçoit P et n.")
    expect(page.locator(".steps-mistake")).to_contain_text("Erreur reconnue. Une seule ligne change.")
    page.keyboard.press("s")
    page.keyboard.press("ArrowRight")
    expect(status).to_have_text("Ligne 3 à exécuter ; la ligne 2 change total.")
    expect(following).to_have_text("3")
    expect(page.locator(".steps-done .steps-number")).to_have_text("2")
    page.get_by_role("spinbutton", name="Boucle ligne 3").fill("3")
    page.keyboard.press("Enter")
    expect(following).to_have_text("4")
    expect(page.locator(".steps-variable", has_text="k").first).to_contain_text("2")
    page.get_by_role("button", name=re.compile(r"Entrer dans f1\(2\) \(3.étapes\)")).click()
    expect(status).to_have_text("Appel de f1, qui reçoit x.")
    expect(page.locator(".steps-crumbs")).to_have_text("f0(tableau 2\u00a0×\u00a02, 3) › f1(2)")
    page.keyboard.press("o")
    expect(page.locator(".steps-variable-changed")).to_contain_text("total")
    expect(page.get_by_role("button", name="Étape suivante")).to_be_focused()
    page.get_by_role("button", name="P", exact=True).click()
    expect(status).to_contain_text("la ligne 5 change P.")
    expect(page.locator("td.steps-changed mark")).to_have_text(["6", "6"])
    expect(page.get_by_role("button", name="P", exact=True)).to_be_focused()
    expect(page.get_by_role("img", name="Dessin de P")).to_be_visible()
    expect(page.locator(".steps-was")).to_have_count(1)
    page.keyboard.press("r")
    page.get_by_role("button", name=re.compile("Ligne 9, 3.passages")).click()
    expect(status).to_contain_text("Passage 1 sur 3.")
    page.keyboard.press("f")
    expect(page.locator(".steps-end")).to_contain_text("Renvoyé")
    page.get_by_text("Toutes les étapes, en tableau").click()
    rows = page.locator(".steps-table tbody tr")
    expect(rows).to_have_count(12)
    expect(rows.nth(2)).to_contain_text("for k in range(n):")
    expect(rows.nth(3)).to_contain_text("appel de f1")
    rows.nth(1).get_by_role("button", name="2").click()
    expect(status).to_have_text("Ligne 2 à exécuter.")
    expect(rows.nth(1)).to_have_attribute("aria-current", "step")
    page.keyboard.press("Escape")
    expect(page.locator("dialog.stepping")).to_have_count(0)


def hostile() -> dict[str, Any]:
    text = {"kind": "text", "text": f"\u202e{HOSTILE}", "length": 9000}
    deep: dict[str, Any] = number(1)
    for _ in range(30):
        deep = {"kind": "sequence", "type": "list", "items": [deep, text], "length": 2, "alias": 3}
    pairs = {"kind": "mapping", "items": [[text, deep]], "length": 10**9, "alias": 4}
    wide = {"kind": "array", "dtype": "float64", "shape": [20, 20], "values": ["nan", "inf", "-1e300", "0"] * 100, "cut": False}
    cube = {"kind": "array", "dtype": "int64", "shape": [0, 3], "values": [], "cut": False}
    scalar = {"kind": "array", "dtype": "float64", "shape": [], "values": ["2.5"], "cut": False}
    other = {"kind": "other", "type": HOSTILE, "name": HOSTILE}
    named = {"t": text, "d": deep, "m": pairs, "w": wide, "c": cube, "s": scalar, "o": other, "__proto__": number(1)}
    many = {f"v{k}": number(k) for k in range(1000)}
    data = trace(f"f = '{HOSTILE}'\n\u202e# x", [step(1, "call"), step(1, **named, **many), step(2, gone=("t",))])
    data["frames"][0]["function"] = HOSTILE
    data["steps"].append(step(2, "exception") | {"words": HOSTILE})
    data["end"] = {"kind": "fault", "value": None, "title": HOSTILE, "message": HOSTILE, "line": 99}
    return data | {"call": HOSTILE, "left_out": [HOSTILE], "stdout": HOSTILE, "mark": {"line": 2, "words": HOSTILE}}


def test_what_a_program_holds_is_shown_and_nothing_more(visit: NewVisit) -> None:
    visitor = visit(width=390, height=844)
    page = opened(visitor, hostile())
    page.keyboard.press("s")
    assert page.locator(".steps-variable").count() < 130
    page.get_by_role("button", name=re.compile("Montrer les")).click()
    expect(page.locator(".steps-variable")).to_have_count(1008)
    for fold in page.locator(".steps-variables details").all()[:4]:
        fold.locator("summary").first.click()
    page.keyboard.press("f")
    expect(page.locator(".steps-end")).to_contain_text(HOSTILE)
    assert page.locator("dialog img, dialog script").count() == 0
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.get_by_role("button", name="Fermer").click()
    opened(visitor, trace("x =", [], ()) | {"end": {"kind": "fault", "title": "Syntaxe", "message": "…", "line": 1}})
    expect(page.locator(".steps-over-fault")).to_contain_text("Syntaxe (ligne 1)")
    expect(page.locator(".steps-controls")).to_have_count(0)


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1280])
def test_axe_finds_nothing_in_a_program_step_by_step(visit: NewVisit, width: int) -> None:
    visitor = visit(width=width)
    page = opened(visitor, looped())
    for _ in range(5):
        page.keyboard.press("s")
    page.get_by_text("Toutes les étapes, en tableau").click()
    page.get_by_text("Au clavier et à la souris").click()
    check(visitor, f"step by step, {width}")
    page.keyboard.press("f")
    check(visitor, f"step by step, its end, {width}")
