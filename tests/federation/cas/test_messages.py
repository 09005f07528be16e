"""What a CAS server says is read within bounds; what is not such a document is refused."""

from __future__ import annotations

import pytest

from server.federation.cas.messages import parse_logout_ticket, parse_validation_answer
from server.federation.errors import FederationRefused

ENT = """<cas:serviceResponse xmlns:cas="http://www.yale.edu/tp/cas"><cas:authenticationSuccess>
<cas:user>uid-4711</cas:user><cas:attributes>
<cas:ENTPersonNom>Lovelace</cas:ENTPersonNom><cas:ENTPersonPrenom>Ada</cas:ENTPersonPrenom>
<cas:ENTEleveClasses>ENTStructureSIREN=1,ou=structures$2NDE5</cas:ENTEleveClasses>
<cas:ENTEleveClasses>ENTStructureSIREN=1,ou=structures$MATHS EXP</cas:ENTEleveClasses>
<cas:attribute name="old" value="style"/><cas:nested><cas:deep>1</cas:deep></cas:nested><cas:empty/>
</cas:attributes></cas:authenticationSuccess></cas:serviceResponse>"""
LOGOUT = """<samlp:LogoutRequest xmlns:samlp="urn:oasis:names:tc:SAML:2.0:protocol" ID="x" Version="2.0"
 IssueInstant="2026-11-28T12:00:00Z">
<saml:NameID xmlns:saml="urn:oasis:names:tc:SAML:2.0:assertion">@NOT_USED@</saml:NameID>
<samlp:SessionIndex>{ticket}</samlp:SessionIndex></samlp:LogoutRequest>"""
BOMB = """<!DOCTYPE bomb [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>"""
ROOT, SUCCESS, USER = "cas:serviceResponse", "cas:authenticationSuccess", "<cas:user>uid-4711</cas:user>"


def test_a_person_comes_with_attributes_of_one_value_or_several() -> None:
    person = parse_validation_answer(ENT.encode())
    assert person.user == "uid-4711"
    assert dict(person.attributes) == {
        "ENTPersonNom": ["Lovelace"],
        "ENTPersonPrenom": ["Ada"],
        "ENTEleveClasses": ["ENTStructureSIREN=1,ou=structures$2NDE5", "ENTStructureSIREN=1,ou=structures$MATHS EXP"],
        "old": ["style"],
    }
    assert parse_validation_answer(f'\n<?xml version="1.0" encoding="UTF-8"?>\n{ENT}'.encode()) == person


REFUSED_ANSWERS = {
    "nothing": b"",
    "HTML": b"<html><body>Connexion</body></html>",
    "an XML bomb": (BOMB + ENT.replace("uid-4711", "&b;")).encode(),
    "a document type alone": ("<!DOCTYPE x>" + ENT).encode(),
    "an entity of a file": ENT.replace("uid-4711", "&f;")
    .replace("<cas:serviceResponse", '<!DOCTYPE x [<!ENTITY f SYSTEM "file:///etc/passwd">]><cas:serviceResponse', 1)
    .encode(),
    "an undeclared entity": ENT.replace("uid-4711", "&nobody;").encode(),
    "UTF-16": ENT.encode("utf-16"),
    "UTF-7 that hides a document type": b'<?xml version="1.0" encoding="utf-7"?>+ADw-!DOCTYPE x+AD4-' + ENT.encode(),
    "another namespace": ENT.replace("yale.edu/tp/cas", "yale.example/tp/cas").encode(),
    "no user": ENT.replace(USER, "").encode(),
    "two users": ENT.replace(USER, USER * 2).encode(),
    "an empty user": ENT.replace("uid-4711", " ").encode(),
    "a user with children": ENT.replace("uid-4711", "uid<cas:x/>-4711").encode(),
    "a user of two lines": ENT.replace("uid-4711", "uid\n4711").encode(),
    "a user that is too long": ENT.replace("uid-4711", "u" * 256).encode(),
    "success beside a failure": ENT.replace(
        f"</{ROOT}>", f'<cas:authenticationFailure code="INVALID_TICKET"/></{ROOT}>'
    ).encode(),
    "two successes": ENT.replace(f"<{SUCCESS}>", f"<{SUCCESS}></{SUCCESS}><{SUCCESS}>").encode(),
    "what is too long": ENT.replace("Lovelace", "L" * 70_000).encode(),
    "what is too deep": ENT.replace("Lovelace", "<a>" * 9_000 + "</a>" * 9_000).encode(),
    "too many elements": ENT.replace("<cas:empty/>", "<cas:empty/>" * 1_001).encode(),
    "a proxy's answer": ENT.replace(SUCCESS, "cas:proxySuccess").encode(),
}


@pytest.mark.parametrize("content", REFUSED_ANSWERS.values(), ids=REFUSED_ANSWERS.keys())
def test_an_answer_that_is_none_is_refused(content: bytes) -> None:
    with pytest.raises(FederationRefused):
        parse_validation_answer(content)


def test_a_failure_says_which() -> None:
    for code, expected in {"INVALID_TICKET": "ticket", "INVALID_SERVICE": "service", "INTERNAL_ERROR": "cas"}.items():
        failure = f'<cas:authenticationFailure code="{code}">no</cas:authenticationFailure>'
        with pytest.raises(FederationRefused) as refused:
            parse_validation_answer(f'<{ROOT} xmlns:cas="http://www.yale.edu/tp/cas">{failure}</{ROOT}>'.encode())
        assert refused.value.code == expected


def test_a_comment_hides_no_part_of_a_user() -> None:
    assert parse_validation_answer(ENT.replace("uid-4711", "admin<!-- x -->-suite").encode()).user == "admin-suite"


def test_a_logout_names_one_ticket() -> None:
    assert parse_logout_ticket(LOGOUT.format(ticket=" ST-1-abc ")) == "ST-1-abc"
    wrong = (
        "",
        "ST-1-abc",
        BOMB + LOGOUT.format(ticket="ST-&b;"),
        LOGOUT.format(ticket=""),
        LOGOUT.format(ticket="PGT-1-abc"),
        LOGOUT.format(ticket="ST-1 abc"),
        LOGOUT.format(ticket="ST-" + "a" * 300),
        LOGOUT.format(ticket="ST-1</samlp:SessionIndex><samlp:SessionIndex>ST-2"),
        LOGOUT.format(ticket="ST-1").replace("samlp:LogoutRequest", "samlp:LogoutResponse"),
        LOGOUT.format(ticket="ST-1").replace("SAML:2.0:protocol", "SAML:9.0:protocol"),
        LOGOUT.format(ticket="ST-1" + "<!-- -->" * 2000),
    )
    for text in wrong:
        with pytest.raises(FederationRefused):
            parse_logout_ticket(text)
