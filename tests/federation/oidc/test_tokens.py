"""No token enters but a good one: each header, each claim and each signature that differs is refused."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import pytest
from joserfc.jwk import RSAKey

from server.federation.discovery import RETRY_SECONDS, Discovery, parse_metadata, preferred_authentication
from server.federation.errors import FederationRefused, OutgoingError
from server.federation.oidc.schemas import OidcSettings
from server.federation.oidc.sign_in import (
    OidcClient,
    authorization_url,
    code_challenge,
    fetch_claims,
    require_own_code,
)
from server.federation.oidc.tokens import verify_id_token, verify_logout_token
from server.federation.proofs import BrowserAnswer
from server.federation.remote_keys import RemoteKeyCache
from tests.support.issuer import CLIENT, ISSUER, KEYS_URL, FakeIssuer, curve_key, sign, signing_key

NOW = int(time.time())
KEYS = RemoteKeyCache(FakeIssuer())  # type: ignore[arg-type]
ODD: tuple[Any, ...] = ("", " ", "autre", 0, 7, -1, 1e30, True, [], {}, ["autre"], {"a": 1}, [None], "a\nb", "x" * 5000)
REMOVED = object()


def verify(token: str, nonce: str = "n") -> Mapping[str, Any]:
    return verify_id_token(token, KEYS, KEYS_URL, issuer=ISSUER, client_id=CLIENT, nonce=nonce, access_token="access")


def end(token: str) -> Any:
    return verify_logout_token(token, KEYS, KEYS_URL, issuer=ISSUER, client_id=CLIENT)


def is_refused(check: Callable[[str], Any], token: str) -> bool:
    try:
        check(token)
    except FederationRefused:
        return True
    return False


def test_a_good_token_enters_by_each_kind_of_key() -> None:
    claims = FakeIssuer().claims()
    for token in (sign(claims), sign(claims, alg="PS256"), sign(claims, key=curve_key(), alg="ES256", kid="ec")):
        assert verify(token)["sub"] == "u1"
    assert verify(sign({**claims, "aud": [CLIENT, "other"]}))["sub"] == "u1"


FORGED: dict[str, Callable[[], str]] = {
    "none": lambda: sign(FakeIssuer().claims(), alg="none"),
    "HS256 with the public key": lambda: sign(FakeIssuer().claims(), alg="HS256"),
    "a key of its own with our id": lambda: sign(FakeIssuer().claims(), key=RSAKey.generate_key(2048)),
    "a key in the header": lambda: sign(FakeIssuer().claims(), jwk=signing_key().as_dict(private=False)),
    "an address of keys": lambda: sign(FakeIssuer().claims(), jku="https://attacker.example/keys"),
    "critical extensions": lambda: sign(FakeIssuer().claims(), crit=["exp"], exp=1),
    "no key": lambda: sign(FakeIssuer().claims(), kid=None),
    "an unknown key": lambda: sign(FakeIssuer().claims(), kid="k2"),
    "another algorithm": lambda: sign(FakeIssuer().claims(), alg="RS512"),
    "the type of a logout": lambda: sign(FakeIssuer().claims(), typ="logout+jwt"),
    "the type of an access token": lambda: sign(FakeIssuer().claims(), typ="at+jwt"),
    "no object": lambda: sign(b"[1]"),
    "no JSON": lambda: sign(b"x"),
    "a deep object": lambda: sign(b'{"a":' * 5000 + b"1" + b"}" * 5000),
    "what is too long": lambda: sign({**FakeIssuer().claims(), "x": "x" * 60_000}),
    "nothing": str,
}


@pytest.mark.parametrize("forge", FORGED.values(), ids=FORGED.keys())
def test_a_forged_token_is_refused(forge: Callable[[], str]) -> None:
    token = forge()
    with pytest.raises(FederationRefused):
        verify(token)


def test_a_signature_covers_each_character() -> None:
    token = sign(FakeIssuer().claims())
    head, body, signature = token.split(".")
    for forged in (f"{head}.{body}.", f"{head}.{body}.{signature[:-4]}AAAA", f"{head}.{body[:-3]}AAA.{signature}"):
        with pytest.raises(FederationRefused):
            verify(forged)


def mutations(name: str) -> list[Any]:
    """Return what a claim may be instead. A list of one is one of the forms of an audience."""
    own: Mapping[str, list[Any]] = {
        "aud": [[CLIENT, "x"], ["x", "y"], CLIENT + " "],
        "iss": [ISSUER + "/", ISSUER.upper(), [ISSUER]],
        "exp": [NOW - 3600, NOW + 10**6, str(NOW + 300)],
        "iat": [NOW - 3600, NOW + 3600, str(NOW)],
        "nbf": [NOW + 3600],
        "nonce": ["N", "n ", ["n"]],
        "sub": ["u1 ", ["u1"], "u\x001"],
    }
    return [*ODD, REMOVED, *own.get(name, [])]


OPTIONAL = {"azp", "at_hash", "sid", "nbf"}
#: Values that are as good, or that the issuer alone can say: another person, another session, a time that has passed.
GOOD = {("sub", "'autre'"), ("sid", "'autre'"), ("nbf", "7"), ("aud", f"['{CLIENT}', 'x']")}


@pytest.mark.parametrize("name", ["iss", "sub", "aud", "azp", "exp", "iat", "nbf", "nonce", "at_hash", "sid"])
def test_no_mutation_of_a_claim_enters(name: str) -> None:
    good = FakeIssuer().claims()
    for value in mutations(name):
        claims = {key: claim for key, claim in good.items() if key != name or value is not REMOVED}
        if value is not REMOVED:
            claims[name] = value
        if (value is REMOVED and name in OPTIONAL) or (name, repr(value)) in GOOD:
            assert verify(sign(claims))["sub"]
            continue
        assert is_refused(verify, sign(claims)), f"{name}: {value!r} entered"


def test_several_audiences_need_an_authorised_party() -> None:
    with pytest.raises(FederationRefused):
        verify(sign(FakeIssuer().claims(aud=[CLIENT, "x"], azp=None)))


def test_a_logout_token_is_no_sign_in_nor_the_reverse() -> None:
    issuer = FakeIssuer()
    assert end(issuer.logout_token()).session == "s1"
    assert end(issuer.logout_token(sid=None, sub="u1")).subject == "u1"
    wrong: tuple[dict[str, Any], ...] = (
        {"iss": "https://other.example"},
        {"aud": "other"},
        {"exp": None},
        {"iat": None},
        {"iat": NOW - 3600},
        {"jti": None},
        {"events": None},
        {"events": {}},
        {"events": []},
        {"events": {"http://schemas.openid.net/event/backchannel-logout": "x"}},
        {"nonce": "n"},
        {"sid": None},
        *({"sid": value} for value in ODD if value != "autre"),
        *({"sub": value} for value in ODD if value != "autre"),
    )
    for change in wrong:
        assert is_refused(end, issuer.logout_token(**change)), f"{change} ended a session"
    with pytest.raises(FederationRefused):
        end(sign(issuer.claims()))
    with pytest.raises(FederationRefused):
        verify(issuer.logout_token())


def test_a_description_is_of_its_issuer_and_https_alone() -> None:
    good = FakeIssuer().metadata
    assert parse_metadata(good, ISSUER).answers_with_issuer
    wrong: tuple[dict[str, Any], ...] = (
        {"issuer": ISSUER + "/"},
        {"issuer": None},
        {"token_endpoint": "http://sso.univ.example/token"},
        {"jwks_uri": "file:///etc/passwd"},
        {"authorization_endpoint": "javascript:alert(1)"},
        {"authorization_endpoint": "https://user:secret@sso.example/"},
        {"userinfo_endpoint": "//sso.univ.example/"},
        {"token_endpoint": "x" * 3000},
        {"code_challenge_methods_supported": ["plain"]},
        {"token_endpoint_auth_methods_supported": "x"},
    )
    for change in wrong:
        with pytest.raises(OutgoingError):
            parse_metadata({**good, **change}, ISSUER)
    for document in (None, [], "x"):
        with pytest.raises(OutgoingError):
            parse_metadata(document, ISSUER)


def test_a_description_is_fetched_seldom_and_outlives_a_server_that_is_away() -> None:
    issuer, now = FakeIssuer(), [1000.0]
    discovery = Discovery(issuer, lambda: now[0])  # type: ignore[arg-type]
    good, issuer.metadata = issuer.metadata, {}
    for _ in range(3):
        with pytest.raises(OutgoingError):
            discovery.find(ISSUER)
    assert len(issuer.requests) == 1
    now[0] += RETRY_SECONDS
    issuer.metadata = good
    assert discovery.find(ISSUER).issuer == ISSUER
    issuer.metadata = {}
    now[0] += 4000
    assert discovery.find(ISSUER).issuer == ISSUER
    assert len(issuer.requests) == 3


def test_the_browser_goes_with_a_challenge_and_comes_from_the_issuer() -> None:
    metadata = parse_metadata(FakeIssuer().metadata, ISSUER)
    client = OidcClient(ISSUER, CLIENT, OidcSettings(service="https://balise.example"), "https://balise.example/retour")
    url = authorization_url(metadata, client, "st", "no", "dBjftJeZ4CVP-mB92K27uhbUJU1p1r_wW1gFWFOEjXk")
    assert "code_challenge=E9Melhoa2OwvFrEMTJguCHaoeK1t8URWbuGJSstw-cM&code_challenge_method=S256" in url  # RFC 7636, B
    assert "scope=openid+profile&state=st&nonce=no" in url
    require_own_code(metadata, BrowserAnswer(code="c", issuer=ISSUER))
    for wrong in (
        BrowserAnswer(code="c"),
        BrowserAnswer(code="c", issuer="https://other.example"),
        BrowserAnswer(issuer=ISSUER),
        BrowserAnswer(code="c", issuer=ISSUER, error="x"),
    ):
        with pytest.raises(FederationRefused):
            require_own_code(metadata, wrong)
    silent = metadata.model_copy(update={"answers_with_issuer": False})
    require_own_code(silent, BrowserAnswer(code="c"))
    with pytest.raises(FederationRefused):
        require_own_code(silent, BrowserAnswer(code="c", issuer="https://other.example"))


def exchange(issuer: FakeIssuer, settings: OidcSettings, **metadata: Any) -> Mapping[str, Any]:
    described = parse_metadata({**issuer.metadata, **metadata}, ISSUER)
    client = OidcClient(ISSUER, CLIENT, settings, "https://balise.example/retour")
    keys = RemoteKeyCache(issuer)  # type: ignore[arg-type]
    code = issuer.new_code("n")
    return fetch_claims(
        issuer,  # type: ignore[arg-type]
        keys,
        described,
        client,
        code,
        nonce="n",
        verifier="v",
        assertion=lambda audience: f"proof for {audience}",
    )


def test_a_code_is_exchanged_with_the_proof_that_the_server_knows() -> None:
    methods = "token_endpoint_auth_methods_supported"
    for settings, known, expected in (
        (OidcSettings(service="https://balise.example", client_secret="s:é"), {}, b"code_verifier=v"),
        (
            OidcSettings(service="https://balise.example", client_secret="s"),
            {methods: ["client_secret_post"]},
            b"client_secret=s",
        ),
        (
            OidcSettings(service="https://balise.example"),
            {methods: ["private_key_jwt"]},
            b"client_assertion=proof+for+https",
        ),
        (OidcSettings(service="https://balise.example"), {}, b"client_id=balise"),
    ):
        issuer = FakeIssuer()
        assert exchange(issuer, settings, **known)["name"] == "Ada Lovelace"
        (_, _, headers, body) = issuer.requests[0]
        assert expected in body
        assert ("Authorization" in headers) == (b"client_id" not in body)
    assert code_challenge("v") != "v"
    assert preferred_authentication(parse_metadata(issuer.metadata, ISSUER), True) == "client_secret_basic"


def test_userinfo_is_of_the_same_person_and_overrides_no_claim() -> None:
    issuer = FakeIssuer()
    where = {"userinfo_endpoint": f"{ISSUER}/userinfo"}
    issuer.userinfo = {"sub": "u1", "name": "Other", "groups": ["a"], "iss": "x"}
    claims = exchange(issuer, OidcSettings(service="https://balise.example"), **where)
    assert (claims["name"], claims["groups"], claims["iss"]) == ("Ada Lovelace", ["a"], ISSUER)
    for document in ({"sub": "u2"}, {}, None, [], {"sub": ["u1"]}):
        issuer.userinfo = document  # type: ignore[assignment]
        with pytest.raises(FederationRefused):
            exchange(issuer, OidcSettings(service="https://balise.example"), **where)
