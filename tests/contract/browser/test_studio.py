"""A teacher's form of an exercise in a real browser: its editors of programs, and what is typed in two tabs."""

from __future__ import annotations

import pytest

from server.identity.models import Role
from tests.support.served import Server
from tests.support.service import new_account

from .conftest import NewVisit, enters, sync_api
from .test_accessibility import check

#: The answer of the server to a save from an older form.
CONFLICT = "409"
EDITOR = "#solution + .editor-host .cm-content"
WIDTHS = (390, 1024, 1280)


@pytest.mark.slow
def test_what_another_tab_saved_meanwhile_is_not_overwritten(visit: NewVisit, server: Server) -> None:
    made = enters(visit(expected=CONFLICT), server.open_database(), new_account(server.open_database(), Role.teacher))
    first = made.open("/mes-exercices")
    first.get_by_role("button", name="Nouvel exercice").click()
    first.wait_for_url("**/mes-exercices/*-*")
    first.locator(EDITOR).press_sequentially("def f(x):\ny = 1\nreturn y")
    sync_api.expect(first.locator("#solution")).to_have_value("def f(x):\n    y = 1\n    return y")
    sync_api.expect(first.locator("[data-saved]")).to_contain_text("Enregistré à")
    second = first.context.new_page()
    second.goto(first.url)
    saved, aside = first.locator("[data-saved]"), first.locator("[data-aside]")
    first.fill("#titre", "Enregistré ici")
    sync_api.expect(saved).to_contain_text("Enregistré à")
    second.fill("#enonce", "Tapé dans l’autre onglet.")
    second.locator(EDITOR).fill("def f(x):\n    return 2")
    sync_api.expect(second.locator("[data-saved]")).to_contain_text("n’est plus enregistré, mais gardé")
    first.reload()
    sync_api.expect(first.locator("#titre")).to_have_value("Enregistré ici")
    sync_api.expect(first.locator("#enonce")).to_have_value("")
    sync_api.expect(aside).to_contain_text("une saisie qui n’est pas enregistrée")
    first.get_by_role("button", name="Reprendre cette saisie").click()
    sync_api.expect(first.locator("#enonce")).to_have_value("Tapé dans l’autre onglet.")
    sync_api.expect(first.locator(EDITOR)).to_contain_text("return 2")
    sync_api.expect(saved).to_contain_text("Enregistré à")
    first.reload()
    first.get_by_role("button", name="Reprendre cette saisie").click()
    sync_api.expect(first.locator("#titre")).to_have_value("Enregistré ici")
    first.get_by_role("button", name="Oublier l’autre version").click()
    sync_api.expect(aside).to_be_hidden()


@pytest.mark.slow
def test_programs_are_typed_in_the_editor_of_students(visit: NewVisit, server: Server) -> None:
    visitor = enters(visit(), server.open_database(), new_account(server.open_database(), Role.teacher))
    page = visitor.open("/mes-exercices")
    page.get_by_role("button", name="Nouvel exercice").click()
    page.wait_for_url("**/mes-exercices/*-*")
    page.get_by_text("Votre solution", exact=True).click()
    expect = sync_api.expect
    expect(page.locator(EDITOR)).to_be_focused()
    page.keyboard.type("def f(x):\n")
    page.keyboard.press("Tab")
    page.keyboard.type("return 1")
    expect(page.locator("#solution")).to_have_value("def f(x):\n        return 1")
    page.keyboard.press("Escape")
    page.keyboard.press("Tab")
    expect(page.get_by_label("Appel n° 1", exact=True)).to_be_focused()
    page.get_by_text("Ajouter une erreur").click()
    page.locator("[data-blank] .cm-content").press_sequentially("def f(x):\nreturn 2")
    page.get_by_text("Ajouter une erreur").click()
    expect(page.locator("[data-blank] .cm-content")).to_have_text("")
    expect(page.locator("#e-0-programme")).to_have_value("def f(x):\n    return 2")
    for width in WIDTHS:
        page.set_viewport_size({"width": width, "height": 800})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        check(visitor, f"the form of an exercise, {width} pixels wide")
    page.locator(EDITOR).press("Control+Enter")
    expect(page.locator("[data-report]")).not_to_contain_text("Écrivez la solution")
    expect(page.locator(EDITOR)).to_contain_text("return 1")
    plain = visit(java_script_enabled=False)
    plain.page.context.add_cookies(page.context.cookies())
    plain.page.goto(page.url)
    expect(plain.page.get_by_label("Votre solution")).to_have_value("def f(x):\n        return 1")


@pytest.mark.slow
def test_a_proposed_case_is_ticked_until_its_author_unticks_it(visit: NewVisit, server: Server) -> None:
    visitor = enters(visit(), server.open_database(), new_account(server.open_database(), Role.teacher))
    page = visitor.open("/mes-exercices")
    page.get_by_role("button", name="Nouvel exercice").click()
    page.wait_for_url("**/mes-exercices/*-*")
    page.locator(EDITOR).fill("def f(a, b):\n    return a * b")
    page.locator("[name=v-0-c-0-appel]").fill("f(2, 2)")
    page.locator("[name=v-0-c-1-appel]").fill("f(0, 0)")
    box, expect = page.locator("[name=cas]").first, sync_api.expect
    expect(box).to_be_checked()
    box.uncheck()
    page.fill("#titre", "Produit")
    expect(page.locator("[data-report]")).not_to_contain_text("Donnez un titre")
    expect(page.locator("[data-trying]")).to_have_count(0)
    expect(box).not_to_be_checked()
