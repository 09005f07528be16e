"""Logins: the same however they are typed, and never two that look alike."""

from __future__ import annotations

from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from uuid import uuid4

import pytest
import sqlalchemy as sa
from hypothesis import given
from hypothesis import strategies as st

from server.database import Database
from server.database.engine import writing_engine
from server.database.migrate import upgrade
from server.identity import repository
from server.identity.logins import find_latin_look_alike, login_problem, normalise_login
from tests.support.service import Site

PASSWORD = "notes sur la machine"


@pytest.mark.parametrize(
    "typed",
    ["ada.office", "ADA.Office", "ada.o\ufb03ce", "ａｄａ.office", "ada.office\u200b", "\ufeffada.off\u00adice\u00a0"],
)
def test_one_login_has_one_form(typed: str) -> None:
    assert normalise_login(typed) == "ada.office"


@given(st.text(max_size=20))
def test_a_folded_login_stays_as_it_is(text: str) -> None:
    login = normalise_login(text)
    assert normalise_login(login) == login


@pytest.mark.parametrize(
    ("login", "words"),
    [
        ("\u0430da", "mélange des lettres cyrilliques et latines (« d », au rang 2)"),
        ("ad\u0430", "mélange des lettres latines et cyrilliques (« \u0430 », au rang 3)"),
        ("\u03bfscar@example.org", "grecques et latines"),
        ("a\u0561a", "arméniennes"),
        ("a b", "sans espace"),
        ("a", "de 2 à 254"),
        ("ada\x07", "U+0007"),
    ],
)
def test_a_login_that_looks_like_another_is_refused_in_words(login: str, words: str) -> None:
    assert words in login_problem(login)


@pytest.mark.parametrize("login", ["иван", "иван@example.org", "eleve.李", "山田はなこ", "zoé-7", "ноель.2", "12345"])
def test_honest_logins_stay(login: str) -> None:
    assert login_problem(login) == ""


def test_a_whole_login_of_look_alike_letters_is_taken_with_its_twin(site: Site) -> None:
    form = {"name": "Ana", "login": "aca", "password": PASSWORD}
    assert site.client.post("/inscription", data=form).status_code == 303
    twin = site.client.post("/inscription", data={**form, "login": "\u0430\u0441\u0430"})
    assert (twin.status_code, "n’est pas disponible" in twin.text) == (422, True)
    assert find_latin_look_alike("\u0430\u0441\u0430") == "aca"
    assert find_latin_look_alike("иван") == "иван"


def test_a_mixed_login_is_refused_at_sign_up_and_the_pasted_one_logs_in(site: Site) -> None:
    form = {"name": "Ana", "login": "ana", "password": PASSWORD}
    mixed = site.client.post("/inscription", data={**form, "login": "\u0430na"})
    assert (mixed.status_code, "cyrilliques et latines" in mixed.text) == (422, True)
    assert site.client.post("/inscription", data=form).status_code == 303
    assert site.client.post("/connexion", data={"login": "ＡＮＡ\u200b", "password": PASSWORD}).status_code == 303


def test_accounts_from_before_keep_a_way_in(tmp_path: Path) -> None:
    """Each is found by the login that its owner types, also where the folded one is somebody else's."""
    old = ["ｏｆｆｉｃｅ", "fin", "ｆｉｎ", "clémence.œuvrard", "\u0430da", "zoé"]
    with closing(Database(f"sqlite:///{tmp_path}/old")) as database:
        upgrade(database.engine, "0021")
        columns = [sa.column("id", sa.Uuid()), sa.column("created_at", sa.DateTime())]
        table = sa.table("account", *columns, *map(sa.column, ("name", "role", "login")))
        with writing_engine(database.engine).begin() as connection:
            for login in old:
                row = {"id": uuid4(), "created_at": datetime.now(UTC), "name": login, "role": "student", "login": login}
                connection.execute(sa.insert(table).values(row))
        upgrade(database.engine)
        with database.read() as db:
            owners = [repository.find_account_by_typed_login(db, login) for login in old]
            assert [owner.name for owner in owners if owner] == old
            assert {owner.login for owner in owners if owner} == {
                "office", "fin", "ｆｉｎ", "clémence.oeuvrard", "\u0430da", "zoé",
            }  # fmt: skip
