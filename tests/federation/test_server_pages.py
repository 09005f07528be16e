"""The administrator's pages of CAS and OpenID Connect servers: registered, tried, saved."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from sqlalchemy import select

from server.audit.models import AuditEvent
from server.base.errors import InvalidFields
from server.federation.models import IdentityProvider, Protocol
from server.federation.rule_forms import parse_claims, parse_rule
from server.identity.models import BrowserSession, Role
from tests.support.classes import person
from tests.support.client import TestClient
from tests.support.issuer import ISSUER, FakeCas, FakeIssuer
from tests.support.schools import CAS, SERVICE, add_server, browser, count, path_of, query_of, stand_in
from tests.support.service import Site

CLAIMS = {"ENTPersonNom": "Lovelace", "ENTPersonPrenom": "Ada", "ENTPersonProfils": "National_ELV", "user": "u1"}
RULE = {"given_name": "ENTPersonPrenom", "family_name": "ENTPersonNom", "role": "ENTPersonProfils"}
TEACHERS = {**RULE, "teachers": "National_ENS\r\nNational_DOC", "students": "National_ELV"}


def administrator(site: Site) -> TestClient:
    return person(site, Role.administrator).browser(site)


def stored(site: Site) -> IdentityProvider:
    with site.database.read() as db:
        return db.execute(select(IdentityProvider)).scalar_one()


def test_a_cas_server_opens_once_its_rule_has_been_tried(site: Site) -> None:
    admin, cas = administrator(site), stand_in(site, FakeCas())
    cas.insecure = True
    form = {"name": "ENT Lumière", "issuer": f"{CAS}/login", "service": SERVICE, "enseignants": "oui"}
    page = "/administration/plateformes/serveur/cas"
    assert "ENT Lumière" in admin.post(page, data={**form, "issuer": "cas.example"}).text
    made = admin.post(page, data=form)
    provider = stored(site)
    rule = f"/administration/plateforme/{provider.id}/regle"
    assert (made.status_code, made.headers["location"], provider.issuer) == (303, rule, CAS)
    assert provider.paused_at is not None
    assert admin.post(page, data=form).status_code == 422
    typed = {**TEACHERS, "claims": json.dumps(CLAIMS)}
    assert admin.post(rule, data={**TEACHERS, "claims": "", "action": "ouvrir"}).status_code == 422
    tried = admin.post(rule, data={**typed, "action": "essayer"})
    assert "<dt>Nom</dt><dd>Ada Lovelace</dd>" in tried.text
    assert "<dt>Rôle</dt><dd>élève</dd>" in tried.text
    mark = re.search(r'name="tried" value="(\w+)"', tried.text)
    assert mark is not None
    changed = admin.post(rule, data={**typed, "students": "", "action": "ouvrir", "tried": mark[1]})
    assert "La règle a changé depuis l’essai" in changed.text
    assert stored(site).paused_at is not None
    saved = admin.post(rule, data={**typed, "action": "ouvrir", "tried": mark[1]})
    assert saved.status_code == 303
    provider = stored(site)
    assert (provider.paused_at, provider.settings["rule"]["teachers"]) == (None, ["National_ENS", "National_DOC"])
    assert "ENT Lumière" in browser(site).get("/connexion").text
    parent = admin.post(rule, data={**typed, "claims": '{"ENTPersonProfils": "National_TUT"}', "action": "essayer"})
    assert "Cette personne n’entre pas" in parent.text
    with site.database.read() as db:
        whats = db.execute(select(AuditEvent.what).order_by(AuditEvent.at)).scalars().all()
    assert whats == ["platform_added", "platform_changed", "platform_resumed"]


def test_a_trial_shows_what_a_system_says_and_opens_nothing(site: Site) -> None:
    provider, issuer = add_server(site.database, Protocol.oidc, opened=False), stand_in(site, FakeIssuer())
    issuer.person["groups"] = ["secret-group"]
    admin, other = administrator(site), administrator(site)
    page = f"/administration/plateforme/{provider.id}"
    answers = []
    for client in (admin, other, browser(site)):
        query = query_of(admin.get(f"{page}/essai").headers["location"])
        back = {"state": query["state"], "code": issuer.new_code(query["nonce"]), "iss": ISSUER}
        answers.append(client.get(f"/connexion/etablissement/{provider.id}/retour", params=back))
    assert answers[0].status_code == 200
    assert "secret-group" in answers[0].text
    assert "<dd>Ada Lovelace</dd>" in answers[0].text
    assert [answer.status_code for answer in answers[1:]] == [403, 403]
    assert "secret-group" not in other.get(page).text
    assert count(site, BrowserSession) == 2


def test_a_secret_is_never_shown_and_stays_unless_it_is_erased(site: Site) -> None:
    admin, issuer = administrator(site), stand_in(site, FakeIssuer())
    issuer.insecure = True
    form = {"name": "Université", "issuer": ISSUER, "client_id": "balise", "service": SERVICE, "scopes": "openid"}
    admin.post("/administration/plateformes/serveur/oidc", data={**form, "client_secret": "s3cr3t-4711"})
    page = f"/administration/plateforme/{stored(site).id}"
    for shown in (page, f"{page}/serveur", "/administration/plateformes"):
        assert "s3cr3t-4711" not in admin.get(shown).text
    assert "secret enregistré" in admin.get(f"{page}/serveur").text
    assert admin.post(f"{page}/serveur", data={**form, "name": "U"}).status_code == 303
    assert (stored(site).name, stored(site).settings["client_secret"]) == ("U", "s3cr3t-4711")
    admin.post(f"{page}/serveur", data={**form, "issuer": "https://other.example", "sans_secret": "oui"})
    assert (stored(site).issuer, stored(site).settings["client_secret"]) == (ISSUER, "")
    assert admin.post(f"{page}/serveur", data={**form, "client_secret": "é" * 9}).status_code == 422
    with site.database.read() as db:
        assert "s3cr3t" not in str([row.before | row.after for row in db.execute(select(AuditEvent)).scalars()])
    assert "publie 2 clés" in admin.post(page, data={"action": "tester"}).text
    issuer.metadata["issuer"] = "https://other.example"
    assert "celle d’un autre serveur" in admin.post(page, data={"action": "tester"}).text
    assert admin.get("/administration/plateformes/serveur/saml").status_code == 404


def test_the_test_of_a_cas_server_asks_it_about_a_ticket(site: Site) -> None:
    provider, cas = add_server(site.database, Protocol.cas), stand_in(site, FakeCas())
    admin, page = administrator(site), f"/administration/plateforme/{provider.id}"
    answer = admin.post(page, data={"action": "tester"})
    assert "Le serveur CAS répond" in answer.text
    assert path_of(cas.requests[0]).startswith("/cas/p3/serviceValidate?")


@pytest.mark.parametrize(
    ("text", "claims"),
    [
        ('{"a": ["b"]}', {"a": ["b"]}),
        ("a: b\n a : c\nd=e:f", {"a": ["b", "c"], "d": ["e:f"]}),
        ("https://x/roles = prof", {"https://x/roles": ["prof"]}),
    ],
)
def test_claims_are_pasted_as_people_have_them(text: str, claims: Any) -> None:
    assert parse_claims(text) == claims


@pytest.mark.parametrize("text", ["", "[1]", "{", "<x/>", "plain", "{}", '"x"', "x" * 70_000, "[" * 60_000])
def test_what_is_no_list_of_claims_is_refused(text: str) -> None:
    with pytest.raises(InvalidFields):
        parse_claims(text)


def test_a_rule_that_cannot_be_is_refused_at_its_field() -> None:
    for form, field in (
        ({"teachers": "prof"}, "role"),
        ({"role": "r", "students": "\n".join(map(str, range(21)))}, "students"),
        ({"class_after": "x" * 11}, "class_after"),
        ({"name": "x" * 300}, "name"),
    ):
        with pytest.raises(InvalidFields) as refused:
            parse_rule(form)
        assert list(refused.value.problems) == [field]
