"""A password that is changed, and one that is forgotten: links by an administrator."""

from __future__ import annotations

import re
from datetime import timedelta
from typing import Any

import pytest
from sqlalchemy import func, select, update

from server.base.errors import Conflict
from server.cli import main
from server.database import utc_now
from server.identity import links, service
from server.identity.models import Account, ApiToken, PasswordLink
from server.identity.repository import find_account
from server.submissions.models import Submission
from tests.support.client import TestClient
from tests.support.service import Site

FORM = {"name": "Ada L.", "login": "ada", "password": "notes sur la machine"}
NEW = "le lidar lit loin"
CHANGE = {"password": FORM["password"], "new_password": NEW}


def browser(site: Site) -> TestClient:
    return TestClient(site.app, follow_redirects=False)


def log_in(client: Any, password: str) -> int:
    status: int = client.post("/connexion", data={"login": "ada", "password": password}).status_code
    return status


def link(site: Site) -> str:
    with site.database.write() as db:
        return links.create_reset_link(db, " ADA ", site.settings)[1]


def count(site: Site, table: type) -> int:
    with site.database.read() as db:
        return db.execute(select(func.count()).select_from(table)).scalar_one()


@pytest.fixture
def ada(site: Site) -> Site:
    site.client.post("/inscription", data=FORM)
    return site


def test_changing_it_asks_for_the_old_one_and_closes_the_other_sessions(ada: Site) -> None:
    other = browser(ada)
    assert log_in(other, FORM["password"]) == 303
    answer = ada.client.post("/compte/mot-de-passe", data=CHANGE)
    assert (answer.status_code, answer.headers["location"]) == (303, "/compte?change=mot-de-passe")
    assert "mot de passe est changé" in ada.client.get(answer.headers["location"]).text
    assert other.get("/compte").status_code == 303, "the other browser is logged out"
    assert (log_in(other, FORM["password"]), log_in(other, NEW)) == (422, 303)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"password": "au hasard"}, "password"),
        ({"new_password": "court"}, "new_password"),
        ({"new_password": "motdepasse"}, "new_password"),
        ({"new_password": "Ada  L. "}, "new_password"),
    ],
)
def test_a_change_that_is_refused_changes_nothing(ada: Site, change: dict[str, str], field: str) -> None:
    answer = ada.client.post("/compte/mot-de-passe", data={**CHANGE, **change})
    assert (answer.status_code, f'id="{field}-probleme"' in answer.text) == (422, True)
    assert log_in(browser(ada), FORM["password"]) == 303


def test_the_old_one_cannot_be_guessed_from_an_open_session(ada: Site) -> None:
    ada.tighten(login_burst=2)
    wrong = {**CHANGE, "password": "au hasard"}
    assert [ada.client.post("/compte/mot-de-passe", data=wrong).status_code for _ in range(3)] == [422, 422, 429]
    assert ada.client.post("/compte/mot-de-passe", data=CHANGE).status_code == 429


def test_a_guest_has_none_to_change(site: Site) -> None:
    site.client.post("/l20/exercices/poses/soumissions", data={"code": "pass"})
    assert site.client.post("/compte/mot-de-passe", data=CHANGE).status_code == 404
    assert browser(site).post("/compte/mot-de-passe", data=CHANGE).status_code == 401


def test_a_link_gives_a_new_password_once_and_closes_all_that_was_open(ada: Site) -> None:
    ada.client.post("/compte/jetons", data={"label": "portable", "password": FORM["password"]})
    old, token = ada.client, link(ada)
    client = browser(ada)
    page = client.get(f"/nouveau-mot-de-passe/{token}")
    assert (page.status_code, "ada" in page.text) == (200, True)
    refused = client.post(f"/nouveau-mot-de-passe/{token}", data={"new_password": "motdepasse"})
    assert (refused.status_code, 'id="new_password-probleme"' in refused.text) == (422, True)
    assert client.post(f"/nouveau-mot-de-passe/{token}", data={"new_password": NEW}).status_code == 303
    assert "Ada L." in client.get("/compte").text, "one is logged in"
    assert old.get("/compte").status_code == 303
    assert count(ada, ApiToken) == 0
    assert client.get(f"/nouveau-mot-de-passe/{token}").status_code == 404
    assert client.post(f"/nouveau-mot-de-passe/{token}", data={"new_password": NEW}).status_code == 404
    assert (log_in(browser(ada), FORM["password"]), log_in(browser(ada), NEW)) == (422, 303)


def test_of_two_uses_at_once_one_only_succeeds(ada: Site) -> None:
    token = link(ada)
    with ada.database.write() as db:
        assert links.consume_password_link(db, token).login == "ada"
        with pytest.raises(Conflict):
            links.consume_password_link(db, token)


def test_a_link_ends_is_replaced_and_goes_with_a_change(ada: Site) -> None:
    first, second = link(ada), link(ada)
    assert ada.client.get(f"/nouveau-mot-de-passe/{first}").status_code == 404
    assert ada.client.get(f"/nouveau-mot-de-passe/{second}").status_code == 200
    with ada.database.write() as db:
        assert db.execute(select(PasswordLink.token_digest)).scalar_one() != second, "it is stored hashed"
        db.execute(update(PasswordLink).values(expires_at=utc_now() - timedelta(seconds=1)))
    assert ada.client.get(f"/nouveau-mot-de-passe/{second}").status_code == 404
    assert ada.client.post(f"/nouveau-mot-de-passe/{second}", data={"new_password": NEW}).status_code == 404
    with ada.database.write() as db:
        service.delete_expired_credentials(db)
    assert count(ada, PasswordLink) == 0
    third = link(ada)
    ada.client.post("/compte/mot-de-passe", data=CHANGE)
    assert ada.client.get(f"/nouveau-mot-de-passe/{third}").status_code == 404


def test_a_guest_s_work_joins_the_account_whose_link_it_opens(ada: Site) -> None:
    guest = browser(ada)
    guest.post("/l20/exercices/poses/soumissions", data={"code": "pass"})
    guest.post(f"/nouveau-mot-de-passe/{link(ada)}", data={"new_password": NEW})
    with ada.database.read() as db:
        owner = db.execute(select(Submission.account_id)).scalar_one()
        account = find_account(db, owner)
    assert account is not None
    assert account.login == "ada"
    assert count(ada, Account) == 1


def test_the_administrator_gets_the_link(ada: Site, capsys: pytest.CaptureFixture[str]) -> None:
    data = ["--data", str(ada.settings.data_dir)]
    assert main(["admin", "reset-link", "Ada", "--server", "https://balise.example/", *data]) == 0
    said = capsys.readouterr().out
    assert "pendant 48 heures" in said
    found = re.search(r"https://balise\.example(/nouveau-mot-de-passe/\S+)", said)
    assert found
    assert ada.client.get(found[1]).status_code == 200
    assert main(["admin", "reset-link", "personne", *data]) == 2
    assert "personne" in capsys.readouterr().err


def test_the_page_of_log_in_says_what_to_do(site: Site) -> None:
    assert "Mot de passe oublié" in site.client.get("/connexion").text


def test_roles_are_given_on_the_command_line_and_one_administrator_stays(
    ada: Site, capsys: pytest.CaptureFixture[str]
) -> None:
    data = ["--data", str(ada.settings.data_dir)]

    def give(role: str) -> int:
        return main(["admin", "role", "Ada", role, *data])

    assert give("teacher") == 0
    assert "enseignant" in capsys.readouterr().out
    assert "Créer une classe" in ada.client.get("/classes").text
    assert give("administrator") == 0
    assert give("student") == 2
    assert "au moins un administrateur" in capsys.readouterr().err
    assert main(["admin", "role", "personne", "teacher", *data]) == 2
