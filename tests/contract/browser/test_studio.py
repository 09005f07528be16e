"""A teacher's form of an exercise in a real browser: what is typed in two tabs."""

from __future__ import annotations

import pytest

from server.identity.models import Role
from tests.support.served import Server
from tests.support.service import new_account

from .conftest import NewVisit, enters, sync_api

#: The answer of the server to a save from an older form.
CONFLICT = "409"


@pytest.mark.slow
def test_what_another_tab_saved_meanwhile_is_not_overwritten(visit: NewVisit, server: Server) -> None:
    made = enters(visit(expected=CONFLICT), server.open_database(), new_account(server.open_database(), Role.teacher))
    first = made.open("/mes-exercices")
    first.get_by_role("button", name="Nouvel exercice").click()
    first.wait_for_url("**/mes-exercices/*-*")
    first.locator("#solution").press_sequentially("def f(x):\ny = 1\nreturn y")
    sync_api.expect(first.locator("#solution")).to_have_value("def f(x):\n    y = 1\n    return y")
    sync_api.expect(first.locator("[data-saved]")).to_contain_text("Enregistré à")
    second = first.context.new_page()
    second.goto(first.url)
    saved, aside = first.locator("[data-saved]"), first.locator("[data-aside]")
    first.fill("#titre", "Enregistré ici")
    sync_api.expect(saved).to_contain_text("Enregistré à")
    second.fill("#enonce", "Tapé dans l’autre onglet.")
    sync_api.expect(second.locator("[data-saved]")).to_contain_text("n’est plus enregistré, mais gardé")
    first.reload()
    sync_api.expect(first.locator("#titre")).to_have_value("Enregistré ici")
    sync_api.expect(first.locator("#enonce")).to_have_value("")
    sync_api.expect(aside).to_contain_text("une saisie qui n’est pas enregistrée")
    first.get_by_role("button", name="Reprendre cette saisie").click()
    sync_api.expect(first.locator("#enonce")).to_have_value("Tapé dans l’autre onglet.")
    sync_api.expect(saved).to_contain_text("Enregistré à")
    first.reload()
    first.get_by_role("button", name="Reprendre cette saisie").click()
    sync_api.expect(first.locator("#titre")).to_have_value("Enregistré ici")
    first.get_by_role("button", name="Oublier l’autre version").click()
    sync_api.expect(aside).to_be_hidden()
