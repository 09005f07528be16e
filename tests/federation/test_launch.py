"""Launches of LTI: a good one enters once, and no other one does."""

from __future__ import annotations

import hmac
import json
import time
from base64 import urlsafe_b64decode, urlsafe_b64encode
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from sqlalchemy import func, select, update

from server.base.http import FRAMED_COOKIE, SESSION_COOKIE
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.federation import providers
from server.federation.errors import FederationRefused
from server.federation.lti.launch import verify_launch
from server.federation.models import IdentityProvider, ProviderActivity, ProviderContext
from server.federation.outgoing import Outgoing
from server.federation.remote_keys import RemoteKeyCache
from server.identity.models import Account, BrowserSession, FederatedIdentity, Role
from tests.support.platforms import (
    ASSISTANT,
    CLAIM,
    CLIENT,
    INSTRUCTOR,
    LEARNER,
    SERVICE,
    Browser,
    Platform,
    private_key,
    query_of,
    sign,
)
from tests.support.service import Site
from tests.support.tables import folded

POSES = "/l20/exercices/poses"
SYSTEM = "http://purl.imsglobal.org/vocab/lis/v2/system/person#"
INSTITUTION = "http://purl.imsglobal.org/vocab/lis/v2/institution/person#"


@pytest.fixture
def platform(site: Site) -> Platform:
    found = Platform()
    found.register(site)
    return found


@pytest.fixture
def browser(site: Site) -> Browser:
    return Browser(site)


def accounts(site: Site) -> list[Account]:
    with site.database.read() as db:
        return list(db.execute(select(Account).order_by(Account.created_at)).scalars())


def sessions(site: Site) -> int:
    with site.database.read() as db:
        return db.execute(select(func.count()).select_from(BrowserSession)).scalar_one()


@pytest.mark.parametrize("method", ["GET", "POST"])
def test_a_student_enters_once_and_comes_back_to_the_same_account(site: Site, platform: Platform, method: str) -> None:
    for _ in range(2):
        browser = Browser(site)
        asked = browser.begin(platform, method=method)
        assert (asked["redirect_uri"], asked["response_mode"]) == (f"{SERVICE}/lti/lancement", "form_post")
        answer = browser.arrive(asked["state"], sign(platform.claims(asked["nonce"])))
        assert (answer.status_code, answer.headers["location"]) == (303, POSES)
        assert "Ada Lovelace" in browser.get(POSES).text
    (account,) = accounts(site)
    assert (account.name, account.role, account.login) == ("Ada Lovelace", Role.student, None)


def test_who_has_no_name_gets_a_pseudonym(site: Site, platform: Platform, browser: Browser) -> None:
    browser.launch(platform, name=None, given_name=None, family_name=None)
    (account,) = accounts(site)
    assert account.has_pseudonym
    assert account.name.startswith("Élève ")


def test_the_session_of_a_frame_is_of_the_frame_and_no_other_site_shows_it(
    site: Site, platform: Platform, browser: Browser
) -> None:
    answer = browser.launch(platform, headers={"Sec-Fetch-Dest": "iframe"})
    cookies = answer.headers.get_list("set-cookie")
    (framed,) = [cookie for cookie in cookies if cookie.startswith(FRAMED_COOKIE)]
    assert framed.endswith("Secure; SameSite=None; Partitioned")
    page = browser.get(POSES)
    assert "Ada Lovelace" in page.text
    assert "frame-ancestors https://moodle.example" in page.headers["content-security-policy"]
    alone = Browser(site)
    answer = alone.launch(platform)
    assert any(cookie.startswith(f"{SESSION_COOKIE}=") for cookie in answer.headers.get_list("set-cookie"))
    assert "frame-ancestors 'none'" in alone.get(POSES).headers["content-security-policy"]


def test_without_cookies_a_tab_is_offered_with_the_same_launch(platform: Platform, browser: Browser) -> None:
    first = browser.get(
        "/lti/connexion",
        params={
            "iss": platform.issuer,
            "login_hint": "u&1",
            "target_link_uri": f"{SERVICE}{POSES}",
            "client_id": CLIENT,
        },
    )
    browser.cookies.clear()
    page = browser.get(first.headers["location"], headers={"Sec-Fetch-Dest": "iframe"})
    assert page.status_code == 200
    assert "Ouvrir dans un onglet" in page.text
    assert "frame-ancestors https://moodle.example" in page.headers["content-security-policy"]
    (again,) = [part.split('"')[0] for part in page.text.split('href="') if part.startswith("/lti/connexion?")]
    assert query_of(again.replace("&amp;", "&"))["login_hint"] == "u&1"
    in_tab = browser.get(again.replace("&amp;", "&"))
    assert in_tab.status_code == 303
    assert browser.get(in_tab.headers["location"]).headers["location"].startswith(platform.issuer)


def refusal(site: Site, answer: Any) -> str:
    """Return why a launch was refused, which nobody entered."""
    assert answer.status_code == 403, answer.text
    assert sessions(site) == 0
    assert not accounts(site)
    return str(answer.text)


OTHER_ROLES = [[], [f"{INSTITUTION}Instructor"], ["Mentor"], [f"{SYSTEM}Administrator", "Mentor"]]

#: Of a good launch: the changed claims, which its platform signs.
FORGED_CLAIMS: Mapping[str, dict[str, Any]] = {
    "wrong issuer": {"iss": "https://evil.example"},
    "wrong audience": {"aud": "another"},
    "several audiences, no azp": {"aud": [CLIENT, "another"]},
    "another azp": {"azp": "another"},
    "empty audience": {"aud": []},
    "audience in audience": {"aud": [[CLIENT]]},
    "wrong deployment": {"deployment_id": "8"},
    "no deployment": {"deployment_id": None},
    "expired": {"iat": int(time.time()) - 700, "exp": int(time.time()) - 100},
    "of long ago": {"iat": int(time.time()) - 4000},
    "of tomorrow": {"iat": int(time.time()) + 4000, "exp": int(time.time()) + 5000},
    "not yet": {"nbf": int(time.time()) + 4000},
    "for a year": {"exp": int(time.time()) + 31_000_000},
    "no end": {"exp": None},
    "no begin": {"iat": None},
    "wrong nonce": {"nonce": "x"},
    "no nonce": {"nonce": None},
    "no subject": {"sub": None},
    "empty subject": {"sub": ""},
    "subject of another type": {"sub": 42},
    "system roles": {"roles": [f"{SYSTEM}Administrator", f"{SYSTEM}SysAdmin"]},
    "roles of another type": {"roles": LEARNER},
    "no roles": {"roles": None},
    "another version": {"version": "1.1"},
    "another message": {"message_type": "LtiSubmissionReviewRequest"},
    "no resource": {"resource_link": None},
    "a course that no database stores": {"context": {"id": "c\0"}},
    "a deployment that no page shows": {"deployment_id": "7\0"},
    "page of another site": {"target_link_uri": "https://evil.example/l20"},
    "page of another site by name": {"target_link_uri": f"{SERVICE}@evil.example/l20"},
    "page of another port": {"target_link_uri": f"{SERVICE}:444/l20"},
    "deep linking by a student": {
        "message_type": "LtiDeepLinkingRequest",
        "https://purl.imsglobal.org/spec/lti-dl/claim/deep_linking_settings": {
            "deep_link_return_url": "https://moodle.example/return", "accept_types": ["ltiResourceLink"]
        },
    },
    "content returned elsewhere": {
        "message_type": "LtiDeepLinkingRequest", "roles": [INSTRUCTOR],
        "https://purl.imsglobal.org/spec/lti-dl/claim/deep_linking_settings": {
            "deep_link_return_url": "https://evil.example/return", "accept_types": ["ltiResourceLink"]
        },
    },
}  # fmt: skip


@folded("case", list(FORGED_CLAIMS))
def test_no_wrong_claim_enters_though_the_platform_signs_it(case: str, site: Site, platform: Platform) -> None:
    refusal(site, Browser(site).launch(platform, **FORGED_CLAIMS[case]))
    assert platform


@pytest.fixture(scope="module")
def other_key() -> Any:
    from joserfc.jwk import RSAKey

    return RSAKey.generate_key(2048, {"kid": "platform-1"})


def encode(part: Any) -> str:
    return urlsafe_b64encode(json.dumps(part).encode()).decode().rstrip("=")


def forged_tokens(claims: Mapping[str, Any], other_key: Any) -> Iterator[tuple[str, str]]:
    """Yield tokens that nobody may enter with: other keys, other algorithms, keys in the header."""
    good = sign(claims)
    header, payload, signature = good.split(".")
    yield "no algorithm", f"{encode({'alg': 'none', 'kid': 'platform-1'})}.{payload}."
    yield "no algorithm, signed", f"{encode({'alg': 'none', 'kid': 'platform-1'})}.{payload}.{signature}"
    public = private_key().as_pem(private=False)
    for secret in (public, public.strip()):
        signed = f"{encode({'alg': 'HS256', 'kid': 'platform-1', 'typ': 'JWT'})}.{payload}"
        mac = urlsafe_b64encode(hmac.digest(secret, signed.encode(), "sha256")).decode().rstrip("=")
        yield "HS256 with the public key", f"{signed}.{mac}"
    yield "another key", sign(claims, None, other_key)
    own = other_key.as_dict(private=False)
    yield "a key in the header", sign(claims, {"jwk": own}, other_key)
    yield "an address of keys in the header", sign(claims, {"jku": "https://evil.example/keys"}, other_key)
    yield "an address of a certificate", sign(claims, {"x5u": "https://evil.example/a.pem"}, other_key)
    yield "an unknown key", sign(claims, {"kid": "platform-2"})
    yield "another type", sign(claims, {"typ": "logout+jwt"})
    yield "no key's name", f"{encode({'alg': 'RS256'})}.{payload}.{signature}"
    yield "PS256 of the header alone", f"{encode({'alg': 'PS256', 'kid': 'platform-1'})}.{payload}.{signature}"
    yield "no signature", f"{header}.{payload}."
    yield "two parts", f"{header}.{payload}"
    yield "no token", "x"
    yield "nested", "[" * 5000
    yield "too long", "a" * 60_000
    changed = json.loads(urlsafe_b64decode(payload + "=="))
    for name in changed:
        for value in ("x", None, 7, [], {}, True):
            yield f"{name} = {value!r}, unsigned", f"{header}.{encode({**changed, name: value})}.{signature}"
        yield f"without {name}", f"{header}.{encode({key: changed[key] for key in changed if key != name})}.{signature}"


class Door:
    """Verifies launches of a platform, as the service does as they arrive."""

    def __init__(self, platform: Platform) -> None:
        self.platform, self.keys = platform, RemoteKeyCache(Outgoing(exchange=platform.exchange))
        self.provider = IdentityProvider(issuer=platform.issuer, client_id=CLIENT, protocol="lti", name="Moodle")

    def enters(self, token: str) -> bool:
        try:
            verify_launch(self.provider, self.platform.settings, token, self.keys, SERVICE)
        except FederationRefused:
            return False
        return True


def test_no_forged_token_enters(other_key: Any) -> None:
    platform = Platform()
    door, claims = Door(platform), platform.claims("n")
    assert door.enters(sign(claims))
    entered = [name for name, token in forged_tokens(claims, other_key) if door.enters(token)]
    assert entered == []


def test_after_forged_tokens_the_good_one_enters(site: Site, platform: Platform, other_key: Any) -> None:
    browser = Browser(site)
    asked = browser.begin(platform)
    claims = platform.claims(asked["nonce"])
    for _, token in list(forged_tokens(claims, other_key))[:6]:
        refusal(site, browser.arrive(asked["state"], token))
    refusal(site, browser.arrive("unknown", sign(claims)))
    assert browser.arrive(asked["state"], sign(claims)).status_code == 303


REQUIRED = ("iss", "aud", "sub", "iat", "exp", "nonce", *(f"{CLAIM}{name}" for name in (
    "version", "message_type", "deployment_id", "roles", "resource_link"
)))  # fmt: skip


def test_no_required_claim_of_another_type_enters_though_it_is_signed() -> None:
    platform = Platform()
    door, claims = Door(platform), platform.claims("n")
    honest = {("sub", "x"), ("nonce", "x"), (f"{CLAIM}roles", "[]")}
    entered = [
        (name, value)
        for name in REQUIRED
        for value in ("x", "", 0, -1, 1e300, True, None, [], {}, [[]], {"id": {}}, ["x", 1])
        if (name, str(value)) not in honest and door.enters(sign({**claims, name: value}))
    ]
    assert entered == []


@folded("case", ["twice", "another browser", "no cookie", "another platform's", "no token", "paused", "removed"])
def test_a_launch_is_of_its_browser_and_its_platform_and_serves_once(case: str, site: Site, platform: Platform) -> None:
    browser = comes = Browser(site)
    asked = browser.begin(platform)
    token = sign(platform.claims(asked["nonce"]))
    if case == "twice":
        assert browser.arrive(asked["state"], token).status_code == 303
    if case in {"another browser", "no cookie"}:
        comes = Browser(site)
    if case == "another browser":
        comes.begin(platform)
    if case == "another platform's":
        token = sign({**platform.claims(asked["nonce"]), "iss": "https://canvas.example"})
    with site.database.write() as db:
        (row,) = db.execute(select(IdentityProvider)).scalars()
        if case == "paused":
            row.paused_at = row.created_at
        if case == "removed":
            providers.remove_provider(db, row, None)
    before = len(accounts(site)), sessions(site)
    answer = comes.arrive(asked["state"], "" if case == "no token" else token)
    assert answer.status_code == 403
    assert (len(accounts(site)), sessions(site)) == before
    if case == "paused":
        with site.database.write() as db:
            db.execute(update(IdentityProvider).values(paused_at=None))


def test_replays_at_once_enter_once(site: Site, platform: Platform) -> None:
    browser = Browser(site)
    asked = browser.begin(platform)
    token, cookies = sign(platform.claims(asked["nonce"])), dict(browser.cookies)

    def replay(_: int) -> int:
        other = Browser(site)
        other.cookies.update(cookies)
        return int(other.arrive(asked["state"], token).status_code)

    with ThreadPoolExecutor(8) as threads:
        answers = list(threads.map(replay, range(40)))
    assert sorted(answers) == [303] + [403] * 39
    assert sessions(site) == 1


@folded("roles", OTHER_ROLES)
def test_roles_outside_of_the_course_give_nothing(roles: list[str], site: Site, platform: Platform) -> None:
    Browser(site).launch(platform, roles=roles, sub="x")
    (account,) = accounts(site)
    assert account.role == Role.student
    with site.database.read() as db:
        assert not db.execute(select(Membership)).all()


@folded(
    "target", ["/lti/lancement", "/administration/plateformes", "/api/v1/me", "/deconnexion", "//evil.example/", ""]
)
def test_some_pages_are_led_to_by_no_launch(target: str, site: Site, platform: Platform) -> None:
    browser = Browser(site)
    asked = browser.begin(platform, target_link_uri=f"{SERVICE}/lti/lancement")
    token = sign(platform.claims(asked["nonce"], target_link_uri=f"{SERVICE}{target}"))
    assert browser.arrive(asked["state"], token).headers["location"] == "/"


def test_an_unknown_platform_or_page_begins_nothing(site: Site, platform: Platform, browser: Browser) -> None:
    good = {"iss": platform.issuer, "login_hint": "u", "target_link_uri": SERVICE}
    for change in ({"iss": "https://evil.example"}, {"target_link_uri": "https://evil.example/"}, {"login_hint": ""},
                   {"client_id": "other"}):  # fmt: skip
        for method, where in (("GET", "params"), ("POST", "data")):
            answer = browser.request(method, "/lti/connexion", **{where: {**good, **change}})  # type: ignore[arg-type]
            assert answer.status_code == 403, change


def test_a_teacher_ties_the_course_and_its_people_get_their_seats(site: Site, platform: Platform) -> None:
    teacher = Browser(site)
    answer = teacher.launch(platform, roles=[INSTRUCTOR], sub="t", name="Grace Hopper")
    page = answer.headers["location"]
    assert page.startswith("/etablissement/cours/")
    assert "Robotique" in teacher.get(page).text
    made = teacher.post(page.split("?")[0], data={"action": "creer", "name": "MPSI", "module": "l20", "suite": "/"})
    assert made.status_code == 303
    for subject, roles in (
        ("s", [LEARNER]),
        ("a", [ASSISTANT]),
        ("t2", [INSTRUCTOR]),
        ("n", [f"{SYSTEM}User", "Mentor"]),
    ):
        Browser(site).launch(platform, roles=roles, sub=subject, name=f"Nom {subject}", given_name=None)
    with site.database.read() as db:
        (school_class,) = db.execute(select(SchoolClass)).scalars()
        rows = db.execute(
            select(FederatedIdentity.subject, Membership.role)
            .join(Membership, Membership.account_id == FederatedIdentity.account_id)
            .where(Membership.status == Status.active)
        )
        assert {row[0]: row[1] for row in rows} == {
            "t": ClassRole.teacher, "s": ClassRole.student, "a": ClassRole.assistant, "t2": ClassRole.teacher
        }  # fmt: skip
    assert made.headers["location"] == f"/classes/{school_class.id}"
    stranger = Browser(site)
    stranger.launch(platform, roles=[LEARNER], sub="z")
    assert stranger.get(page).status_code == 404
    again = Browser(site).launch(platform, roles=[LEARNER], sub="s", target_link_uri=SERVICE + "/")
    assert again.headers["location"] == f"/classes/{school_class.id}"


def test_who_has_an_account_here_is_asked_whether_it_is_theirs(site: Site, platform: Platform) -> None:
    browser = Browser(site)
    browser.post("/inscription", data={"name": "Ada", "login": "ada", "password": "quatre mots sans rapport"})
    location = browser.launch(platform).headers["location"]
    assert location.startswith("/compte/rejoindre?identifiant=ada")
    joined = browser.post(
        "/compte/rejoindre", data={"login": "ada", "password": "quatre mots sans rapport", "suite": POSES}
    )
    assert joined.headers["location"] == POSES
    (account,) = accounts(site)
    assert account.login == "ada"


def test_an_administrator_sees_what_a_platform_did_last(site: Site, platform: Platform) -> None:
    Browser(site).launch(platform)
    Browser(site).launch(platform, deployment_id="99")
    with site.database.read() as db:
        rows = list(db.execute(select(ProviderActivity)).scalars())
        assert {row.succeeded for row in rows} == {True, False}
        assert any("« 99 »" in row.detail for row in rows)
        assert not any("Ada" in row.detail for row in rows)
        (context,) = db.execute(select(ProviderContext)).scalars()
        assert (context.title, context.line_items_url) == ("Robotique", "https://moodle.example/items?type_id=3")
