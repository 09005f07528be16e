"""Platforms are set by an administrator: by hand, or by themselves at an address that serves once."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from sqlalchemy import select

from server.audit.models import AuditAction, AuditEvent
from server.base.app_services import add_services
from server.federation.lti.schemas import lti_settings
from server.federation.models import IdentityProvider
from server.identity.models import Account, Role
from tests.support.classes import person
from tests.support.client import TestClient
from tests.support.platforms import CLIENT, SERVICE, Browser, Platform
from tests.support.service import Site
from tests.support.tables import folded

CONFIGURATION = "https://moodle.example/mod/lti/openid-configuration.php"
TOOL = "https://purl.imsglobal.org/spec/lti-tool-configuration"


class Registrar(Platform):
    """Registers tools, once with each token."""

    def __init__(self) -> None:
        super().__init__()
        self.changes: dict[str, Any] = {}
        self.asked: list[Mapping[str, Any]] = []
        self.handlers = {"/mod/lti/openid-configuration.php": self.configuration, "/register": self.answer}

    def configuration(self, *_: Any) -> tuple[int, Mapping[str, str], bytes]:
        document = {
            "issuer": self.issuer,
            "authorization_endpoint": self.settings.authorization_url,
            "token_endpoint": self.settings.token_url,
            "jwks_uri": self.settings.keys_url,
            "registration_endpoint": f"{self.issuer}/register",
        }
        return 200, {}, json.dumps({**document, **self.changes}).encode()

    def answer(
        self, _method: str, _url: str, headers: Mapping[str, str], content: bytes
    ) -> tuple[int, Mapping[str, str], bytes]:
        assert headers["Authorization"] == "Bearer jeton-1"
        self.asked.append(json.loads(content))
        answer = {"client_id": CLIENT, TOOL: {"deployment_id": "7"}}
        return 201, {}, json.dumps(answer).encode()


@pytest.fixture
def registrar(site: Site) -> Registrar:
    found = Registrar()
    add_services(site.app, found.federation(site))
    return found


@pytest.fixture
def administrator(site: Site) -> TestClient:
    return TestClient(
        site.app, base_url=SERVICE, cookies=person(site, Role.administrator).cookies, follow_redirects=False
    )


def new_address(administrator: TestClient) -> str:
    page = administrator.post("/administration/plateformes/lien")
    (address,) = re.findall(r"https://balise\.example(/lti/inscription/[\w-]+)", page.text)
    return str(address)


def platforms(site: Site) -> list[IdentityProvider]:
    with site.database.read() as db:
        return list(db.execute(select(IdentityProvider)).scalars())


def test_a_platform_registers_itself_and_its_people_enter(
    site: Site, registrar: Registrar, administrator: TestClient
) -> None:
    address, browser = new_address(administrator), Browser(site)
    form = {"openid_configuration": CONFIGURATION, "registration_token": "jeton-1"}
    page = browser.get(address, params=form)
    assert "https://moodle.example" in page.text
    assert "frame-ancestors https://moodle.example" in page.headers["content-security-policy"]
    assert browser.post(address, data=form).status_code == 200
    (platform,) = platforms(site)
    assert (platform.issuer, platform.client_id) == ("https://moodle.example", CLIENT)
    assert lti_settings(platform) == registrar.settings
    (asked,) = registrar.asked
    assert (asked["response_types"], asked["token_endpoint_auth_method"]) == (["id_token"], "private_key_jwt")
    assert asked["redirect_uris"] == [asked[TOOL]["target_link_uri"]] == [f"{SERVICE}/lti/lancement"]
    assert {message["type"] for message in asked[TOOL]["messages"]} == {
        "LtiResourceLinkRequest", "LtiDeepLinkingRequest"
    }  # fmt: skip
    assert "name" in asked[TOOL]["claims"]
    assert asked[TOOL]["domain"] == "balise.example"
    assert Browser(site).launch(registrar).status_code == 303
    for again in (browser.get(address, params=form), browser.post(address, data=form)):
        assert again.status_code == 403
        assert "déjà servi" in again.text
    assert len(registrar.asked) == 1


def test_of_several_registrations_at_once_one_succeeds(
    site: Site, registrar: Registrar, administrator: TestClient
) -> None:
    address = new_address(administrator)
    form = {"openid_configuration": CONFIGURATION, "registration_token": "jeton-1"}
    with ThreadPoolExecutor(4) as threads:
        answers = list(threads.map(lambda _: Browser(site).post(address, data=form).status_code, range(8)))
    assert sorted(answers) == [200] + [403] * 7
    assert (len(registrar.asked), len(platforms(site))) == (1, 1)


@folded(
    "changes",
    [
        {"issuer": "https://evil.example"},
        {"registration_endpoint": "https://evil.example/register"},
        {"jwks_uri": "http://moodle.example/certs.php"},
        {"token_endpoint": None},
        {"issuer": ["https://moodle.example"]},
        {"authorization_endpoint": "javascript:alert(1)"},
        {"authorization_endpoint": "https://*;script-src/auth"},
    ],
)
def test_a_configuration_of_other_hosts_registers_nothing(
    changes: Mapping[str, Any], site: Site, registrar: Registrar, administrator: TestClient
) -> None:
    registrar.changes = dict(changes)
    form = {"openid_configuration": CONFIGURATION, "registration_token": "jeton-1"}
    assert Browser(site).get(new_address(administrator), params=form).status_code == 403
    assert Browser(site).post(new_address(administrator), data=form).status_code == 403
    assert (registrar.asked, platforms(site)) == ([], [])


def test_an_address_by_hand_or_an_unknown_one_registers_nothing(
    site: Site, registrar: Registrar, administrator: TestClient
) -> None:
    form = {"openid_configuration": CONFIGURATION, "registration_token": "jeton-1"}
    assert Browser(site).get(new_address(administrator)).status_code == 403
    assert Browser(site).post("/lti/inscription/inconnue", data=form).status_code == 403
    assert registrar.requests == []


FORM = {
    "name": "Moodle du lycée", "issuer": "https://moodle.example", "client_id": "c1", "deployments": "7 8",
    "authorization_url": "https://moodle.example/auth.php", "token_url": "https://moodle.example/token.php",
    "keys_url": "https://moodle.example/certs.php", "enseignants": "oui",
}  # fmt: skip


def test_an_administrator_registers_changes_tests_pauses_and_removes(
    site: Site, registrar: Registrar, administrator: TestClient
) -> None:
    page = administrator.post("/administration/plateformes/lti", data=FORM).headers["location"]
    (platform,) = platforms(site)
    assert lti_settings(platform).deployments == ("7", "8")
    assert lti_settings(platform).frames == ("https://moodle.example",)
    tested = administrator.post(page, data={"action": "tester"})
    assert "publie 1 clé, et nous donne accès à l’envoi des notes" in tested.text
    registrar.handlers["/certs.php"] = registrar.answer
    administrator.post(page, data={"action": "deploiement", "deploiement": "9"})
    administrator.post(
        f"{page}/lti", data={**FORM, "name": "Moodle", "keys_url": "https://moodle.example/k", "deployments": "9"}
    )
    administrator.post(page, data={"action": "suspendre"})
    (platform,) = platforms(site)
    assert (platform.name, lti_settings(platform).deployments, platform.paused_at is None) == ("Moodle", ("9",), False)
    failed = administrator.post(page, data={"action": "tester"})
    assert (failed.status_code, "réponse 404" in failed.text) == (422, True)
    for action in ("reprendre", "retirer"):
        administrator.post(page, data={"action": action})
    assert platforms(site) == []
    with site.database.read() as db:
        events = db.execute(select(AuditEvent).where(AuditEvent.class_id.is_(None)).order_by(AuditEvent.at)).scalars()
        assert [event.what for event in events] == [
            AuditAction.platform_added, AuditAction.platform_changed, AuditAction.platform_changed,
            AuditAction.platform_paused, AuditAction.platform_resumed, AuditAction.platform_removed,
        ]  # fmt: skip
        assert len(db.execute(select(Account)).all()) == 1
    assert "plateforme retirée" in administrator.get("/administration/journal").text


@folded(
    ("field", "value"),
    [
        ("issuer", "http://moodle.example"), ("keys_url", "moodle.example/certs"), ("token_url", ""), ("name", ""),
        ("client_id", " "), ("frames", "https://moodle.example/path"), ("frames", "https://a.example;script-src"),
        ("frames", "* 'self'"), ("deployments", " ".join(map(str, range(60)))),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_said_beside_its_field_and_nothing_typed_is_lost(
    field: str, value: str, site: Site, administrator: TestClient
) -> None:
    page = administrator.post("/administration/plateformes/lti", data={**FORM, field: value})
    assert page.status_code == 422
    assert f'id="{field}-probleme"' in page.text
    assert 'value="Moodle du lycée"' in page.text or field == "name"
    assert platforms(site) == []


def test_one_issuer_has_one_list_of_keys(site: Site, administrator: TestClient) -> None:
    administrator.post("/administration/plateformes/lti", data=FORM)
    other_keys = administrator.post(
        "/administration/plateformes/lti", data={**FORM, "client_id": "c2", "keys_url": "https://evil.example/certs"}
    )
    assert "d’autres adresses de clés" in other_keys.text
    assert administrator.post("/administration/plateformes/lti", data=FORM).status_code == 422
    assert administrator.post("/administration/plateformes/lti", data={**FORM, "client_id": "c2"}).status_code == 303
    assert len(platforms(site)) == 2
