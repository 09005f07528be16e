"""A program step by step in a real browser: gone through by keys, clicks and table; whatever it holds, harmless."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest

from tests.contract.browser.conftest import NewVisit, Page, Visit, sync_api
from tests.contract.browser.test_accessibility import check
from tests.contract.browser.test_story import SOLUTION
from tests.steps.page_scripts import number, step, trace

expect = sync_api.expect
WRONG = f"""{SOLUTION}

def composer(a, b):
    x = a[0] + b[0]
    y = a[1] + b[1]
    return np.array([x, y, ramener(a[2] + b[2])])
"""
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
    return {
        "kind": "array",
        "dtype": "float64",
        "shape": [len(values) // 2, 2],
        "values": texts,
        "cut": False,
        "alias": 1,
    }


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
    page.get_by_role("list", name="Le code, ligne à ligne").focus()
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    expect(following).to_have_text("6")
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
    wide = {
        "kind": "array",
        "dtype": "float64",
        "shape": [20, 20],
        "values": ["nan", "inf", "-1e300", "0"] * 100,
        "cut": False,
    }
    cube = {"kind": "array", "dtype": "int64", "shape": [0, 3], "values": [], "cut": False}
    scalar = {"kind": "array", "dtype": "float64", "shape": [], "values": ["2.5"], "cut": False}
    other = {"kind": "other", "type": HOSTILE, "name": HOSTILE}
    named = {"t": text, "d": deep, "m": pairs, "w": wide, "c": cube, "s": scalar, "o": other, "__proto__": number(1)}
    many = {f"v{k}": number(k) for k in range(300)}
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
    expect(page.locator(".steps-variable")).to_have_count(308)
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


@pytest.mark.slow
def test_a_counterexample_is_replayed_from_the_verdict_then_a_call_of_ones_own(visit: NewVisit) -> None:
    visitor = visit(expected="422")
    page = visitor.open()
    visitor.submit(WRONG)
    page.locator(".check-failed").first.get_by_role("button", name="Rejouer pas à pas").click()
    dialog = page.get_by_role("dialog", name="Pas à pas")
    expect(dialog.locator(".steps-call")).to_contain_text("composer(np.array([")
    expect(dialog.locator(".steps-keyword").first).to_be_visible()
    call = dialog.locator(".steps-call").inner_text()
    dialog.get_by_role("button", name="a", exact=True).click()
    expect(dialog.locator(".steps-status")).to_have_text("a ne change plus.")
    page.keyboard.press("s")
    page.keyboard.press("s")
    expect(dialog.locator(".steps-variable-changed .steps-name")).to_have_text("x")
    page.keyboard.press("f")
    expect(dialog.locator(".steps-end")).to_contain_text("Attendu")
    expect(dialog.locator(".steps-end .got")).to_contain_text("Renvoyé")
    page.keyboard.press("Escape")
    expect(dialog).to_have_count(0)
    expect(page.locator(".check-failed").first.get_by_role("button", name="Rejouer pas à pas")).to_be_focused()

    own = page.locator("details", has=page.locator("#appel"))
    own.locator("summary").click()
    field = own.get_by_label("Appel d’une de vos fonctions")
    expect(field).to_have_value(call)
    field.fill("composer(a, b)")
    field.press("Enter")
    expect(own.get_by_role("alert")).to_contain_text("« a » n’est pas connu ici")
    expect(field).to_be_focused()
    expect(field).to_have_attribute("aria-invalid", "true")
    output = own.get_by_role("log")
    own.get_by_role("button", name="inverse").click()
    own.get_by_role("button", name="Exécuter").click()
    expect(output).to_contain_text("Renvoyé")
    field.fill("")
    own.get_by_role("button", name="Exécuter").click()
    expect(output).to_have_text("Votre fichier s’exécute, et n’affiche rien.")
    field.fill("nulle_part()")
    own.get_by_role("button", name="Exécuter").click()
    expect(output.locator(".cell-fault")).to_contain_text("nulle_part")
    own.get_by_role("button", name="inverse").click()
    expect(own.get_by_role("alert")).to_be_hidden()
    own.get_by_role("button", name="Rejouer pas à pas").click()
    expect(dialog.locator(".steps-status")).to_have_text("Appel de inverse, qui reçoit a.")


@pytest.mark.slow
def test_a_cell_is_replayed_as_the_reader_has_changed_it(visit: NewVisit) -> None:
    visitor = visit()
    page = visitor.open("/l20/lire/localiser")
    cell = page.locator("section.cell").first
    cell.get_by_role("button", name="Modifier").click()
    visitor.write("total = 0\nfor k in range(40):\n    total = total + k\nprint(total)")
    cell.get_by_role("button", name="Rejouer pas à pas").click()
    dialog = page.get_by_role("dialog", name="Pas à pas")
    dialog.get_by_role("button", name="Dernière étape").click()
    expect(dialog.locator(".steps-end")).to_contain_text("Le programme est allé au bout")
    expect(dialog.locator(".steps-variable", has_text="total")).to_contain_text("780")
    dialog.get_by_text("Ce que le code a affiché").click()
    expect(dialog.locator(".printed")).to_have_text("780\n")
    dialog.get_by_role("button", name=re.compile("Ligne 2, 4[01].passages")).click()
    dialog.get_by_role("button", name="dernier", exact=True).click()
    expect(dialog.get_by_role("spinbutton")).to_have_value("40")
    page.keyboard.press("Escape")
    visitor.write("x = (")
    cell.get_by_role("button", name="Rejouer pas à pas").click()
    expect(dialog.locator(".steps-over-fault")).to_be_visible()
