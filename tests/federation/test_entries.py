"""Sign-in from our own page by CAS and OpenID Connect, from button to session, and its refusals."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import quote

import pytest
from sqlalchemy import select

from server.base.http import SESSION_COOKIE
from server.database import Database
from server.federation import pending, providers
from server.federation.errors import FederationRefused
from server.federation.models import IdentityProvider, PendingSignIn, Protocol
from server.identity.models import Account, BrowserSession, FederatedIdentity, Role
from tests.support.classes import person
from tests.support.client import TestClient
from tests.support.issuer import ISSUER, FakeCas, FakeIssuer, sign
from tests.support.schools import CAS, SERVICE, add_server, browser, count, path_of, query_of, stand_in
from tests.support.service import Site, new_account

LOGOUT = (
    '<samlp:LogoutRequest xmlns:samlp="urn:oasis:names:tc:SAML:2.0:protocol" ID="a">'
    "<samlp:SessionIndex>{}</samlp:SessionIndex></samlp:LogoutRequest>"
)


def enter_by_cas(client: TestClient, provider: IdentityProvider, cas: FakeCas, after: str = "") -> Any:
    """Go through the whole sign-in, and return the last answer and the address of return."""
    away = client.get(f"/connexion/etablissement/{provider.id}{after}")
    service = query_of(away.headers["location"])["service"]
    ticket = cas.new_ticket(service)
    back = f"{path_of(service)}&ticket={ticket}"
    return client.get(back), back


def enter_by_oidc(client: TestClient, provider: IdentityProvider, issuer: FakeIssuer, **changes: str) -> Any:
    away = client.get(f"/connexion/etablissement/{provider.id}")
    query = query_of(away.headers["location"])
    back = {"state": query["state"], "code": issuer.new_code(query["nonce"]), "iss": ISSUER, **changes}
    return client.get(f"/connexion/etablissement/{provider.id}/retour", params=back), back


def test_a_pupil_comes_by_cas_and_leaves_with_it(site: Site) -> None:
    provider, cas, ada = add_server(site.database, Protocol.cas), stand_in(site, FakeCas()), browser(site)
    entered, back = enter_by_cas(ada, provider, cas, "?suite=/classes")
    assert (entered.status_code, entered.headers["location"]) == (303, "/classes")
    assert entered.headers["cache-control"] == "no-store"
    with site.database.read() as db:
        (identity,) = db.execute(select(FederatedIdentity)).scalars()
        assert (identity.issuer, identity.subject) == (CAS, "u1")
        assert db.execute(select(Account.role, Account.login)).all() == [(Role.student, None)]
    ticket = query_of(back)["ticket"]
    door = f"/connexion/etablissement/{provider.id}/retour"
    for forged in (LOGOUT.format("ST-999-other"), "", "x", LOGOUT.format(ticket).replace("SessionIndex", "Index")):
        browser(site).post(f"{door}?etat=x", data={"logoutRequest": forged})
        assert count(site, BrowserSession) == 1
    assert browser(site).post(f"{door}?etat=x", data={"logoutRequest": LOGOUT.format(ticket)}).status_code == 200
    assert count(site, BrowserSession) == 0


def test_a_person_comes_by_openid_connect_with_a_guests_work(site: Site) -> None:
    provider, issuer, ada = add_server(site.database, Protocol.oidc), stand_in(site, FakeIssuer()), browser(site)
    entered, _ = enter_by_oidc(ada, provider, issuer)
    assert (entered.status_code, entered.headers["location"]) == (303, "/")
    assert "Ada Lovelace" in ada.get("/compte").text
    assert "balise_etat_" not in "".join(name for name in ada.cookies)
    (again, _) = enter_by_oidc(browser(site), provider, issuer)
    assert again.status_code == 303
    assert (count(site, Account), count(site, BrowserSession)) == (1, 2)


def test_what_has_been_used_enters_no_more(site: Site) -> None:
    oidc, cas = add_server(site.database, Protocol.oidc), add_server(site.database, Protocol.cas)
    for provider, system, enter in ((oidc, FakeIssuer(), enter_by_oidc), (cas, FakeCas(), enter_by_cas)):
        stand_in(site, system)
        client = browser(site)
        _, back = enter(client, provider, system)
        asked, sessions = len(system.requests), count(site, BrowserSession)
        again = f"/connexion/etablissement/{provider.id}/retour"
        replayed = client.get(back) if isinstance(back, str) else client.get(again, params=back)
        assert replayed.status_code == 403
        assert "déjà servi" in replayed.text
        assert (len(system.requests), count(site, BrowserSession)) == (asked, sessions)


def test_another_browser_does_not_enter_with_this_ones_state(site: Site) -> None:
    """Neither by a link that is sent to somebody, nor with a ticket that was made for another sign-in."""
    cas, provider = stand_in(site, FakeCas()), add_server(site.database, Protocol.cas)
    mallory, victim = browser(site), browser(site)
    away = mallory.get(f"/connexion/etablissement/{provider.id}")
    service = query_of(away.headers["location"])["service"]
    link = f"{path_of(service)}&ticket={cas.new_ticket(service)}"
    assert victim.get(link).status_code == 403
    victim.get(f"/connexion/etablissement/{provider.id}")
    assert victim.get(link).status_code == 403
    for forged in ("", "x", "ST-", "PT-1-abc", "ST-0-abcdef%26service=x", "ST-0-abc%0A"):
        fresh = browser(site)
        own = query_of(fresh.get(f"/connexion/etablissement/{provider.id}").headers["location"])["service"]
        assert fresh.get(f"{path_of(own)}&ticket={forged}").status_code == 403
    stolen = cas.new_ticket("https://other.example/")
    own = query_of(victim.get(f"/connexion/etablissement/{provider.id}").headers["location"])["service"]
    assert victim.get(f"{path_of(own)}&ticket={stolen}").status_code == 403
    assert count(site, BrowserSession) == 0


def test_a_host_that_a_request_names_makes_no_service_of_ours(site: Site) -> None:
    provider = add_server(site.database, Protocol.cas)
    stand_in(site, FakeCas())
    away = browser(site).get(f"/connexion/etablissement/{provider.id}", headers={"Host": "evil.example"})
    assert query_of(away.headers["location"])["service"].startswith(f"{SERVICE}/connexion/etablissement/{provider.id}")


@pytest.mark.parametrize(
    "target", ["https://evil.example", "//evil.example", "/\\evil.example", "javascript:x", "\t//e"]
)
def test_no_page_of_another_site_is_gone_to(site: Site, target: str) -> None:
    provider, cas = add_server(site.database, Protocol.cas), stand_in(site, FakeCas())
    client = browser(site)
    away = client.get(f"/connexion/etablissement/{provider.id}", params={"suite": target})
    service = query_of(away.headers["location"])["service"]
    entered = client.get(f"{path_of(service)}&ticket={cas.new_ticket(service)}&suite={quote(target)}")
    assert entered.headers["location"] == "/"


def test_answers_of_openid_connect_that_are_not_ours_are_refused(site: Site) -> None:
    provider, issuer = add_server(site.database, Protocol.oidc), stand_in(site, FakeIssuer())
    for changes in (
        {"iss": ""},
        {"iss": "https://other.example"},
        {"code": ""},
        {"code": "x"},
        {"error": "access_denied"},
    ):
        assert enter_by_oidc(browser(site), provider, issuer, **changes)[0].status_code == 403
    for name, value in (
        ("nonce", "other"),
        ("aud", "other"),
        ("iss", "https://other.example"),
        ("exp", 1),
        ("sub", None),
    ):
        issuer.token_changes = {name: value}
        assert enter_by_oidc(browser(site), provider, issuer)[0].status_code == 403
    assert (count(site, BrowserSession), count(site, Account)) == (0, 0)


def test_a_system_that_is_away_is_named_and_opens_nothing(site: Site) -> None:
    provider, issuer = add_server(site.database, Protocol.oidc), stand_in(site, FakeIssuer())
    issuer.metadata = {}
    away = browser(site).get(f"/connexion/etablissement/{provider.id}")
    assert (away.status_code, "« Lycée »" in away.text) == (503, True)


def test_a_system_ends_its_sessions_by_name_or_person(site: Site) -> None:
    provider, issuer = add_server(site.database, Protocol.oidc), stand_in(site, FakeIssuer())
    other = new_account(site.database)
    door = f"/connexion/etablissement/{provider.id}/deconnexion"

    def end(token: str, status: int = 200) -> int:
        assert browser(site).post(door, data={"logout_token": token}).status_code == status
        return count(site, BrowserSession)

    for _ in range(2):
        enter_by_oidc(browser(site), provider, issuer)
    person(site, account=other)
    forged = (
        "",
        "x",
        sign(issuer.claims()),
        sign(issuer.claims(), alg="none"),
        issuer.logout_token(aud="other"),
        issuer.logout_token(nonce="n"),
    )
    for token in forged:
        assert end(token, 400) == 3
    assert end(issuer.logout_token(sid="unknown")) == 3
    assert end(issuer.logout_token(sid=None, sub="somebody")) == 3
    assert end(issuer.logout_token()) == 1
    enter_by_oidc(browser(site), provider, issuer)
    assert end(issuer.logout_token(sid=None, sub="u1")) == 1


def test_an_order_to_log_out_of_before_ends_no_later_session(site: Site) -> None:
    provider, issuer = add_server(site.database, Protocol.oidc), stand_in(site, FakeIssuer())
    token = issuer.logout_token(sid=None, sub="u1", iat=issuer.claims()["iat"] - 300)
    enter_by_oidc(browser(site), provider, issuer)
    browser(site).post(f"/connexion/etablissement/{provider.id}/deconnexion", data={"logout_token": token})
    assert count(site, BrowserSession) == 1


def test_one_system_does_not_end_or_finish_what_another_has_begun(site: Site) -> None:
    first, second = (
        add_server(site.database, Protocol.cas),
        add_server(site.database, Protocol.cas, issuer="https://cas2.example"),
    )
    cas, client = stand_in(site, FakeCas()), browser(site)
    _, back = enter_by_cas(client, first, cas)
    ticket = query_of(back)["ticket"]
    data = {"logoutRequest": LOGOUT.format(ticket)}
    browser(site).post(f"/connexion/etablissement/{second.id}/retour", data=data)
    assert count(site, BrowserSession) == 1
    service = query_of(client.get(f"/connexion/etablissement/{first.id}").headers["location"])["service"]
    moved = path_of(service).replace(str(first.id), str(second.id))
    assert client.get(f"{moved}&ticket={cas.new_ticket(service)}").status_code == 403


def test_a_paused_system_lets_nobody_in_and_shows_no_button(site: Site) -> None:
    provider, cas, client = add_server(site.database, Protocol.cas), stand_in(site, FakeCas()), browser(site)
    door = f"/connexion/etablissement/{provider.id}"
    assert door in client.get("/connexion").text
    service = query_of(client.get(door).headers["location"])["service"]
    with site.database.write() as db:
        found = providers.find_provider(db, provider.id)
        found.paused_at = found.created_at
    assert door not in client.get("/connexion").text
    assert client.get(door).status_code == 403
    assert client.get(f"{path_of(service)}&ticket={cas.new_ticket(service)}").status_code == 403
    assert count(site, BrowserSession) == 0


def test_no_administrator_enters_by_a_school(site: Site) -> None:
    provider, cas = add_server(site.database, Protocol.cas), stand_in(site, FakeCas())
    account = new_account(site.database, Role.administrator)
    with site.database.write() as db:
        db.add(FederatedIdentity(account_id=account.id, issuer=CAS, subject="u1"))
    refused, _ = enter_by_cas(browser(site), provider, cas)
    assert (refused.status_code, count(site, BrowserSession)) == (403, 0)


def test_a_state_enters_once_however_many_come_at_once(database: Database) -> None:
    provider = add_server(database, Protocol.oidc)
    with database.write() as db:
        begun, _ = pending.begin_own_sign_in(db, provider.id, "/", {"verifier": "v"})

    def take(_: int) -> bool:
        try:
            with database.write() as db:
                pending.consume_own_sign_in(db, provider.id, begun.state, begun.browser)
        except FederationRefused:
            return False
        return True

    with ThreadPoolExecutor(8) as pool:
        assert sum(pool.map(take, range(64))) == 1
    with database.read() as db:
        assert db.execute(select(PendingSignIn)).first() is None


def test_buttons_lead_on_to_the_page_that_was_asked_for(site: Site) -> None:
    first = add_server(site.database, Protocol.cas)
    add_server(site.database, Protocol.oidc, name="Université")
    page = browser(site).get("/connexion?suite=/classes").text
    assert f'href="/connexion/etablissement/{first.id}?suite=/classes"' in page
    assert page.index("Université") < page.index("Avec un identifiant de Balise")
    refused = browser(site).post("/connexion", data={"login": "ada", "password": "x"})
    assert (refused.status_code, "Université" in refused.text) == (422, True)
    assert SESSION_COOKIE not in refused.cookies
