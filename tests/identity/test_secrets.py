"""Secrets end with their reason: tokens with the password, and log-in attempts of a known browser are its own."""

from __future__ import annotations

import re
from datetime import timedelta
from typing import Any

import pytest
from sqlalchemy import select
from starlette.concurrency import run_in_threadpool

from server.base.settings import Settings
from server.cli import main
from server.database import Database, utc_now
from server.identity import administration, devices, links, repository, secrets
from server.identity.models import Account, ApiToken, BrowserSession, KnownDevice, Role
from server.identity.schemas import RefusedForm
from tests.support.client import TestClient
from tests.support.quick import in_a_loop
from tests.support.service import Site, new_account

FORM = {"name": "Ada L.", "login": "ada", "password": "notes sur la machine"}
NEW = "le lidar lit loin"
API = "/api/v1/exercises"


def browser(site: Site) -> TestClient:
    return TestClient(site.app, follow_redirects=False)


def log_in(client: Any, password: str = FORM["password"], login: str = "ada") -> int:
    status: int = client.post("/connexion", data={"login": login, "password": password}).status_code
    return status


@pytest.fixture
def ada(site: Site) -> Site:
    site.client.post("/inscription", data=FORM)
    return site


def create(client: Any, password: str = FORM["password"]) -> Any:
    return client.post("/compte/jetons", data={"label": "portable", "password": password})


def headers(client: Any) -> dict[str, str]:
    found = re.search(r'id="jeton">(balise_[\w-]{43})<', create(client).text)
    assert found
    return {"Authorization": f"Bearer {found[1]}"}


def use(site: Site, token: dict[str, str]) -> int:
    return browser(site).get(API, headers=token).status_code


@pytest.mark.parametrize(
    "fields", [{}, {"password": ""}, {"password": "au hasard"}, {"new_password": FORM["password"]}]
)
def test_no_token_is_made_without_the_password(ada: Site, fields: dict[str, str]) -> None:
    answer = ada.client.post("/compte/jetons", data={"label": "mon portable", **fields})
    assert answer.status_code == 422
    assert 'id="token_password-probleme"' in answer.text
    assert 'value="mon portable"' in answer.text, "the name that was typed is still there"
    with ada.database.read() as db:
        assert db.execute(select(ApiToken)).first() is None


def test_a_guest_makes_no_token_and_is_told_what_to_do(site: Site) -> None:
    site.client.post("/l20/exercices/poses/soumissions", data={"code": "pass"})
    refused = create(site.client, "")
    assert refused.status_code == 403
    assert "créez un compte" in refused.text
    assert 'href="/inscription?suite=/compte"' in site.client.get("/compte").text


def test_the_password_of_a_token_is_not_guessed(ada: Site) -> None:
    ada.tighten(login_burst=3)
    assert [create(ada.client, "au hasard").status_code for _ in range(4)] == [422, 422, 422, 429]
    assert create(ada.client).status_code == 429


def change_password(site: Site) -> None:
    site.client.post("/compte/mot-de-passe", data={"password": FORM["password"], "new_password": NEW})


def reset_password(site: Site) -> None:
    with site.database.write() as db:
        _, token = links.create_reset_link(db, "ada", site.settings)
    assert browser(site).post(f"/nouveau-mot-de-passe/{token}", data={"new_password": NEW}).status_code == 303


def run_admin(*action: str) -> Any:
    def act(site: Site) -> None:
        assert main(["admin", *action, "--data", str(site.settings.data_dir)]) == 0

    return act


@pytest.mark.parametrize(
    "end",
    [
        change_password,
        reset_password,
        run_admin("disable", "ada"),
        run_admin("role", "ada", "teacher"),
        run_admin("role", "ada", "administrator"),
        run_admin("revoke", "ada", "--all"),
    ],
)
def test_a_token_ends_with_its_reason(ada: Site, end: Any) -> None:
    token = headers(ada.client)
    assert use(ada, token) == 200
    end(ada)
    assert use(ada, token) == 401
    with ada.database.read() as db:
        assert db.execute(select(ApiToken)).first() is None, "nor does it come back"


def test_a_role_that_stays_ends_nothing(ada: Site) -> None:
    token = headers(ada.client)
    run_admin("role", "ada", "student")(ada)
    assert use(ada, token) == 200


DOORS = (
    ("POST", "/compte/jetons"), ("POST", "/compte/mot-de-passe"), ("POST", "/compte/supprimer"), ("GET", "/compte"),
    ("GET", "/compte/donnees"), ("GET", "/compte/supprimer"),
)  # fmt: skip


@pytest.mark.parametrize(("method", "path"), DOORS)
def test_a_token_opens_no_door_of_the_account(ada: Site, method: str, path: str) -> None:
    token = headers(ada.client)
    fields = {"label": "autre", "password": FORM["password"], "new_password": NEW}
    data = {"data": fields} if method == "POST" else {}
    answer = browser(ada).request(method, path, headers=token, **data)
    assert answer.status_code in {303, 401}
    assert answer.headers.get("location", "/connexion").startswith("/connexion")
    assert "set-cookie" not in answer.headers


@pytest.mark.parametrize("body", [{}, {"json": {"password": ""}}, {"json": {"password": "au hasard"}}, {"json": None}])
def test_a_token_erases_no_account(ada: Site, body: dict[str, Any]) -> None:
    token = headers(ada.client)
    assert browser(ada).request("DELETE", "/api/v1/me", headers=token, **body).status_code in {403, 422}
    assert use(ada, token) == 200


def test_a_token_that_a_guest_has_from_before_erases_nothing_and_ends_as_they_sign_up(site: Site) -> None:
    token = site.token(Role.guest)
    refused = site.client.request("DELETE", "/api/v1/me", headers=token, json={"password": ""})
    assert refused.status_code == 403
    assert site.client.get(API, headers=token).status_code == 200


def test_a_token_is_not_made_with_a_password_that_changes_meanwhile(ada: Site) -> None:
    """The password is verified outside of any transaction: that takes a tenth of a second."""
    with ada.database.read() as db:
        account = repository.find_account_by_login(db, "ada")
    assert account is not None
    verify = ada.accounts.hashing.verify

    async def verify_slowly(*arguments: Any, **options: Any) -> bool:
        is_right = await verify(*arguments, **options)
        changed = await run_in_threadpool(secrets.hash_password, NEW)
        with ada.database.write() as db:
            repository.set_password(db, account.id, changed)
        return is_right

    object.__setattr__(ada.accounts.hashing, "verify", verify_slowly)
    with pytest.raises(RefusedForm):
        in_a_loop(ada.accounts.create_token(account, "x", FORM["password"], session="s", address="a"))
    unchanged = secrets.hash_password(FORM["password"])
    with ada.database.write() as db:
        repository.set_password(db, account.id, unchanged)
        before = len(repository.load_sessions(db, account.id))
    with pytest.raises(RefusedForm):
        in_a_loop(ada.accounts.log_in("ada", FORM["password"], visitor=None, address="a"))
    with ada.database.read() as db:
        assert db.execute(select(ApiToken)).first() is None
        assert len(repository.load_sessions(db, account.id)) == before


def test_wrong_passwords_from_the_same_address_lock_nobody_out_of_a_browser_that_they_use(ada: Site) -> None:
    ada.tighten(login_burst=3, guest_burst=5, guest_refill_seconds=1000.0, login_refill_seconds=1000.0)
    own, neighbour = ada.client, browser(ada)
    own.post("/deconnexion")
    assert [log_in(neighbour, "au hasard") for _ in range(4)] == [422, 422, 422, 429]
    assert [log_in(neighbour, "au hasard", f"x{number}") for number in range(6)] == [422] * 5 + [429]
    assert log_in(neighbour) == 429, "the neighbour is not let in, even with the password"
    assert log_in(own) == 303
    assert create(own).status_code == 200, "nor do they use up the tries of an open session"


def test_a_known_browser_is_bounded_too_and_by_itself_alone(ada: Site) -> None:
    ada.tighten(login_burst=3, login_refill_seconds=1000.0)
    ada.client.post("/deconnexion")
    assert [log_in(ada.client, "au hasard") for _ in range(4)] == [422, 422, 422, 429]
    assert log_in(browser(ada)) == 303, "another browser has its own"


def test_a_browser_is_known_for_the_accounts_that_logged_in_there_alone(ada: Site) -> None:
    """An account of one's own gives no tries against somebody else's."""
    bob = browser(ada)
    bob.post("/inscription", data={**FORM, "login": "bob"})
    ada.tighten(login_burst=2, login_refill_seconds=1000.0)
    assert [log_in(browser(ada), "au hasard"), log_in(bob, "au hasard"), log_in(bob)] == [422, 422, 429]
    stolen = browser(ada)
    stolen.cookies["balise_device"] = "de-mon-choix"
    assert log_in(stolen) == 429


def test_tries_with_the_right_password_are_given_back(ada: Site) -> None:
    ada.tighten(login_burst=2, login_refill_seconds=1000.0)
    assert [log_in(browser(ada)) for _ in range(5)] == [303] * 5


def test_nobody_chooses_the_token_of_a_browser(ada: Site) -> None:
    planted = browser(ada)
    planted.cookies["balise_device"] = "de-mon-choix"
    planted.post("/connexion", data=FORM)
    with ada.database.read() as db:
        digests = set(db.execute(select(KnownDevice.token_digest)).scalars())
    assert secrets.sha256_hex("de-mon-choix") not in digests
    assert len(digests) == 2
    again = ada.client.cookies["balise_device"]
    log_in(ada.client)
    assert ada.client.cookies["balise_device"] == again, "a browser keeps its own"


def test_unknown_logins_are_told_and_throttled_as_known_ones_are(ada: Site) -> None:
    new_account(ada.database)
    hashed = secrets.hash_password("x")
    with ada.database.write() as db:
        db.add(Account(name="Sans mot de passe", login="sans"))
        db.add(Account(name="S", login="suspendu", password_hash=hashed, disabled_at=utc_now()))
    ada.tighten(login_burst=2, login_refill_seconds=1000.0)

    def answers(login: str) -> list[tuple[int, str]]:
        tries = [browser(ada).post("/connexion", data={"login": login, "password": "au hasard"}) for _ in range(3)]
        said = re.compile(r'role="alert">([^<]*)<')
        return [(answer.status_code, "".join(said.findall(answer.text))) for answer in tries]

    expected = answers("personne")
    assert [status for status, _ in expected] == [422, 422, 429]
    assert answers("ada") == answers("sans") == answers("suspendu") == expected


def test_the_password_is_verified_for_nobody_as_for_somebody(ada: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    verified: list[str | None] = []
    real = secrets.verify_password

    def counted(password: str, stored: str | None) -> bool:
        verified.append(stored)
        return real(password, stored)

    monkeypatch.setattr(secrets, "verify_password", counted)
    for login in ("ada", "personne", "a b", "", "x" * 300):
        log_in(browser(ada), "au hasard", login)
    assert [stored is None for stored in verified] == [False, True, True, True, True]


def test_both_databases_forget_browsers(database: Database, both: Settings) -> None:
    account, now = new_account(database), utc_now()
    with database.write() as db:
        made = [devices.remember_device(db, account.id, "", now - timedelta(days=days)) for days in range(30)]
        assert len(repository.load_devices(db, account.id)) == devices.MAX_DEVICES
        assert devices.is_known_device(db, made[0], account)
        assert not devices.is_known_device(db, made[0], None)
        assert not devices.is_known_device(db, made[-1], account)
        assert devices.remember_device(db, account.id, made[0], now) == made[0]
        devices.forget_stale_devices(db, now + timedelta(days=devices.DEVICE_DAYS - 5))
        assert len(repository.load_devices(db, account.id)) == 6
        administration.disable_account(db, db.get_one(Account, account.id))
        assert repository.load_devices(db, account.id) == []


def test_a_password_changed_elsewhere_ends_the_other_sessions(ada: Site) -> None:
    other, third = browser(ada), browser(ada)
    assert [log_in(other), log_in(third)] == [303, 303]
    assert (
        other.post("/compte/mot-de-passe", data={"password": FORM["password"], "new_password": NEW}).status_code == 303
    )
    assert [client.get("/compte").status_code for client in (ada.client, other, third)] == [303, 200, 303]
    with ada.database.read() as db:
        assert len(db.execute(select(BrowserSession)).all()) == 1
