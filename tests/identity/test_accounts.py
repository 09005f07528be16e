"""Guests, sign-up, log-in, the one-time link, API tokens; cookies and cross-site requests."""

from __future__ import annotations

import re
from datetime import timedelta
from http.cookies import SimpleCookie

import pytest
from sqlalchemy import select, update

from server.base.errors import NotFound
from server.database import utc_now
from server.identity import links, login_attempts, secrets, service
from server.identity.models import Account, ApiToken, BrowserSession, Invitation, Role
from server.identity.schemas import RefusedForm, validate_new_account
from server.submissions.models import Submission
from tests.support.client import TestClient
from tests.support.quick import in_a_loop
from tests.support.service import Site

FORM = {"name": "Ada L.", "login": "Ada@Example.org", "password": "notes sur la machine"}
POST = "/l20/exercices/poses/soumissions"
FULL_STRENGTH = secrets._password_hash  # before a fixture puts a weaker one there


def send(site: Site, code: str = "pass") -> None:
    answer = site.client.post(POST, data={"code": code})
    assert answer.status_code < 400, answer.text


def accounts(site: Site) -> list[Account]:
    with site.database.read() as db:
        return list(db.execute(select(Account).order_by(Account.created_at)).scalars())


def owners(site: Site) -> list[object]:
    with site.database.read() as db:
        return list(db.execute(select(Submission.account_id)).scalars())


def test_looking_around_creates_nobody(site: Site) -> None:
    for path in ("/", "/l20", "/l20/exercices/poses", "/connexion", "/inscription"):
        answer = site.client.get(path)
        assert answer.status_code == 200
        assert "set-cookie" not in answer.headers
    assert accounts(site) == []


def test_a_guest_is_a_real_account_bound_to_the_browser(site: Site) -> None:
    send(site)
    send(site, "pass  # encore")
    (guest,) = accounts(site)
    assert guest.role == Role.guest
    assert owners(site) == [guest.id, guest.id]
    assert "invité" in site.client.get("/compte").text


def test_signing_up_keeps_the_guest_s_work_and_changes_the_session(site: Site) -> None:
    send(site)
    (guest,) = accounts(site)
    old = site.client.cookies["balise_session"]
    answer = site.client.post("/inscription", data={**FORM, "suite": "/l20"})
    assert (answer.status_code, answer.headers["location"]) == (303, "/l20")
    (named,) = accounts(site)
    assert (named.id, named.role, named.name, named.login) == (guest.id, Role.student, "Ada L.", "ada@example.org")
    assert owners(site) == [named.id]
    assert site.client.cookies["balise_session"] != old
    with site.database.read() as db:
        assert service.find_account_by_session_token(db, old) is None


def test_a_guest_who_logs_in_brings_the_work_along(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    site.client.post("/deconnexion")
    send(site)
    assert len(accounts(site)) == 2
    answer = site.client.post("/connexion", data={"login": " ADA@example.org", "password": FORM["password"]})
    assert answer.status_code == 303
    (named,) = accounts(site)
    assert owners(site) == [named.id]


@pytest.mark.parametrize(
    "change", [{"password": "court"}, {"login": "a b"}, {"login": ""}, {"name": " "}, {"name": "x" * 101}]
)
def test_a_bad_form_says_why_and_creates_nobody(site: Site, change: dict[str, str]) -> None:
    answer = site.client.post("/inscription", data={**FORM, **change})
    assert answer.status_code == 422
    assert 'role="alert"' in answer.text
    assert accounts(site) == []


def test_a_login_is_taken_once(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    site.client.post("/deconnexion")
    answer = site.client.post("/inscription", data={**FORM, "login": "ADA@EXAMPLE.ORG"})
    assert (answer.status_code, "pas disponible" in answer.text) == (422, True)
    assert len(accounts(site)) == 1


def test_wrong_passwords_are_refused_then_throttled(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    site.client.post("/deconnexion")
    guess = {"login": FORM["login"], "password": "au hasard"}
    site.tighten(login_burst=2)
    for _ in range(2):
        assert site.client.post("/connexion", data=guess).status_code == 422
    answer = site.client.post("/connexion", data={**guess, "password": FORM["password"]})
    assert answer.status_code == 429
    assert int(answer.headers["retry-after"]) >= 1


def test_a_school_s_pupils_enter_from_one_address_and_guesses_are_counted(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(login_attempts, "FLOODED_SECONDS", 0.0)
    site.client.post("/inscription", data=FORM)
    site.tighten(guest_burst=2, guest_refill_seconds=1000.0, login_burst=100)
    right = {"login": FORM["login"], "password": FORM["password"]}

    def tried(**form: str) -> int:
        site.client.cookies.clear()
        return site.client.post("/connexion", data=form).status_code

    assert [tried(**right) for _ in range(4)] == [303] * 4
    assert [tried(login=f"a{number}", password="au hasard") for number in range(3)] == [422, 422, 429]
    assert tried(**right) == 303, "who floods an address with wrong logins keeps nobody from a first log-in there"
    assert tried(**{**right, "password": "au hasard"}) == 429, "nobody learns who exists"


def test_an_unknown_login_reads_like_a_wrong_password(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    site.client.post("/deconnexion")
    answers = [
        site.client.post("/connexion", data={"login": login, "password": "au hasard"}).text
        for login in ("ada@example.org", "bob@example.org")
    ]
    assert answers[0].replace("ada@", "") == answers[1].replace("bob@", "")


def test_the_one_time_link_makes_one_teacher(site: Site) -> None:
    with site.database.write() as db:
        first = links.create_administrator_invitation(db)
    with site.database.write() as db:
        token = links.create_administrator_invitation(db)
    assert site.client.get(f"/bienvenue/{first}").status_code == 404, "a newer link replaces it"
    assert site.client.get(f"/bienvenue/{token}").status_code == 200
    assert site.client.post(f"/bienvenue/{token}", data={**FORM, "password": "court"}).status_code == 422
    assert site.client.post(f"/bienvenue/{token}", data=FORM).status_code == 303
    (teacher,) = accounts(site)
    assert teacher.role == Role.administrator
    site.client.cookies.clear()
    assert site.client.get(f"/bienvenue/{token}").status_code == 404
    assert site.client.post(f"/bienvenue/{token}", data={**FORM, "login": "bob"}).status_code == 404
    assert len(accounts(site)) == 1
    with site.database.write() as db:
        assert links.create_administrator_invitation(db) is None


def test_a_refused_form_does_not_use_the_link(site: Site) -> None:
    with site.database.write() as db:
        token = links.create_administrator_invitation(db)
        db.add(Account(name="Bob", login="bob"))
    wanted = validate_new_account("Ada", "bob", FORM["password"])
    with pytest.raises(RefusedForm):
        in_a_loop(site.accounts.sign_up(wanted, visitor=None, address="x", invitation=token))
    with site.database.read() as db:
        assert db.execute(select(Invitation.used_at)).scalar_one() is None
    wanted = validate_new_account("Ada", "ada", FORM["password"])
    in_a_loop(site.accounts.sign_up(wanted, visitor=None, address="x", invitation=token))
    with pytest.raises(NotFound):
        in_a_loop(site.accounts.sign_up(wanted, visitor=None, address="x", invitation=token))


def test_a_teacher_opens_a_solution_and_a_student_may_not(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    assert site.client.post("/l20/exercices/poses/corrige", data={"ouvrir": "true"}).status_code == 403


def test_api_tokens_are_shown_once_stored_hashed_and_revoked(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    page = site.client.post("/compte/jetons", data={"label": "portable", "password": FORM["password"]}).text
    found = re.search(r'id="jeton">(balise_[\w-]{43})<', page)
    assert found
    headers = {"Authorization": f"Bearer {found[1]}"}
    assert found[1] not in site.client.get("/compte").text
    assert site.client.get("/api/v1/exercises", headers=headers).status_code == 200
    with site.database.read() as db:
        token = db.execute(select(ApiToken)).scalar_one()
    assert found[1] not in (token.token_digest, token.label)
    stranger = TestClient(site.client.app, follow_redirects=False)
    stranger.post("/inscription", data={**FORM, "login": "bob"})
    assert stranger.post(f"/compte/jetons/{token.id}/revoquer").status_code == 404
    assert site.client.post(f"/compte/jetons/{token.id}/revoquer").status_code == 303
    assert site.client.get("/api/v1/exercises", headers=headers).status_code == 401


def test_what_is_stored_opens_nothing(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    cookie = site.client.cookies["balise_session"]
    with site.database.read() as db:
        stored = db.execute(select(BrowserSession.token_digest)).scalar_one()
        hashed = db.execute(select(Account.password_hash)).scalar_one()
        assert service.find_account_by_session_token(db, stored) is None
        assert service.find_account_by_session_token(db, cookie) is not None
    assert hashed is not None
    assert hashed.startswith("$argon2id$")


def test_passwords_are_stored_at_full_strength(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(secrets, "_password_hash", FULL_STRENGTH)
    stored = secrets.hash_password(FORM["password"])
    assert stored.startswith("$argon2id$v=19$m=65536,t=3,p=4$")
    assert secrets.verify_password(FORM["password"], stored)
    assert not secrets.verify_password("au hasard", stored)


@pytest.mark.parametrize(("scheme", "secure"), [("http", ""), ("https", True)])
def test_the_cookie_is_out_of_reach_of_scripts_and_other_sites(site: Site, scheme: str, secure: object) -> None:
    client = TestClient(site.client.app, base_url=f"{scheme}://balise.test", follow_redirects=False)
    cookie = SimpleCookie(client.post("/inscription", data=FORM).headers["set-cookie"])["balise_session"]
    assert (cookie["httponly"], cookie["samesite"], cookie["secure"], cookie["path"]) == (True, "Lax", secure, "/")


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Sec-Fetch-Site": "cross-site"}, 403),
        ({"Sec-Fetch-Site": "same-site"}, 403),
        ({"Sec-Fetch-Site": "same-origin"}, 303),
        ({"Origin": "https://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "http://[::1"}, 403),
        ({"Origin": "http://testserver"}, 303),
        ({}, 303),
    ],
)
def test_requests_forged_by_another_site_are_refused(site: Site, headers: dict[str, str], status: int) -> None:
    assert site.client.post("/deconnexion", headers=headers).status_code == status


@pytest.mark.parametrize(
    "after", ["https://evil.example/", "//evil.example", "/\\evil.example", "javascript:alert(1)", "//[::1", "http://["]
)
def test_nobody_is_sent_to_another_site(site: Site, after: str) -> None:
    assert site.client.post("/inscription", data={**FORM, "suite": after}).headers["location"] == "/"


def test_a_referrer_that_is_no_address_leads_home(site: Site) -> None:
    assert site.client.post("/nulle-part", headers={"Referer": "http://[::1"}).status_code == 404


def test_security_headers_are_everywhere(site: Site) -> None:
    for path in ("/", "/nulle-part", "/api/v1/exercises", "/compte"):
        headers = site.client.get(path).headers
        assert "script-src 'self';" in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"


def test_ended_sessions_open_nothing_and_are_forgotten(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    with site.database.write() as db:
        db.execute(update(BrowserSession).values(expires_at=utc_now() - timedelta(seconds=1)))
    assert site.client.get("/compte").status_code == 303
    with site.database.write() as db:
        service.delete_expired_credentials(db)
    with site.database.read() as db:
        assert db.execute(select(BrowserSession)).first() is None


def test_new_visitors_from_one_address_are_bounded(site: Site) -> None:
    site.tighten(guest_burst=2, guest_refill_seconds=1000.0)
    statuses = []
    for _ in range(3):
        site.client.cookies.clear()
        statuses.append(site.client.post(POST, data={"code": "pass"}).status_code)
    assert [status < 400 for status in statuses] == [True, True, False]
    assert statuses[-1] == 429


def test_only_a_guest_acts_without_a_password(site: Site) -> None:
    service = site.accounts
    guest = service.create_guest("192.0.2.1").account
    external = Account(role=Role.student, name="Ada", login=None)
    with site.database.write() as db:
        db.add(external)
    in_a_loop(service.require_password(guest, "", credential="g", address="192.0.2.1"))
    with pytest.raises(RefusedForm):
        in_a_loop(service.require_password(external, "", credential="e", address="192.0.2.1"))
