"""LemonLDAP::NG, of Debian's packages: CAS and OpenID Connect from one session of its portal, and the end of CAS's.

Version 2.16 has no back-channel logout of OpenID Connect, and calls a page in the browser instead.

Packages: liblemonldap-ng-portal-perl, libplack-perl, libgd-securityimage-perl, libimage-magick-perl, libio-string-perl,
libxml-simple-perl and libstring-random-perl. Where they are absent, this test is skipped.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import httpx2 as httpx
import pytest
from sqlalchemy import select

from server.federation.models import Protocol
from server.identity.models import BrowserSession
from tests.contract.federation.test_servers import GROUPS, arrived, courses, register
from tests.support.live import PATIENCE, until
from tests.support.peers import free_port, read, running, submit
from tests.support.served import Server

PORTAL = Path("/usr/share/lemonldap-ng/portal/htdocs/index.psgi")
#: Expressions of Perl, which give these attributes to whoever logs in.
PUPIL = {
    "ENTPersonPrenom": "'Doctor'",
    "ENTPersonNom": "'Who'",
    "ENTPersonProfils": "'National_ELV'",
    "ENTEleveClasses": "'ENTStructureSIREN=1,ou=structures$2NDE5'",
    "roles": "'/roles/etudiant; /classes/L2 info'",
}
INI = """[all]
[configuration]
type=File
dirName={folder}/conf
localStorage=Cache::FileCache
localStorageOptions={{'namespace'=>'configuration','default_expires_in'=>600,'cache_root'=>'{folder}/cache'}}
[portal]
templateDir=/usr/share/lemonldap-ng/portal/templates
staticPrefix=/static
languages=fr
"""


def configure(folder: Path, portal: str, service: str, oidc_back: str) -> Path:
    """Write the configuration of a portal that knows Balise as a service of CAS and a client of OpenID Connect."""
    from joserfc.jwk import RSAKey

    key, storage = RSAKey.generate_key(2048), {"Directory": f"{folder}/sessions", "LockDirectory": f"{folder}/locks"}
    for name in ("conf", "cache", "sessions", "locks"):
        (folder / name).mkdir()
    module = {"generateModule": "Lemonldap::NG::Common::Apache::Session::Generate::SHA256"}
    client = {
        "ClientID": "balise", "ClientSecret": "secret-of-a-test", "RedirectUris": f"{oidc_back}/retour",
        "IDTokenSignAlg": "RS256", "BypassConsent": 1, "LogoutUrl": f"{oidc_back}/deconnexion", "LogoutType": "back",
        "LogoutSessionRequired": 1, "RequirePKCE": 1, "UserIDAttr": "uid",
    }  # fmt: skip
    document: dict[str, Any] = {
        "cfgNum": 1, "cfgAuthor": "test", "cfgDate": 1, "key": "key of a test", "portal": f"{portal}/",
        "domain": "127.0.0.1", "securedCookie": 0, "authentication": "Demo", "userDB": "Same", "passwordDB": "Demo",
        "registerDB": "Null", "demoExportedVars": {"uid": "uid", "cn": "cn"}, "macros": PUPIL, "requireToken": 0,
        "portalForceAuthn": 0, "trustedDomains": "*", "locationRules": {}, "exportedHeaders": {},
        "globalStorage": "Apache::Session::File", "globalStorageOptions": {**storage, **module},
        "localSessionStorage": "Cache::FileCache",
        "localSessionStorageOptions": {"namespace": "sessions", "cache_root": f"{folder}/cache"},
        "issuerDBCASActivation": 1, "casAccessControlPolicy": "error", "casBackChannelSingleLogout": 1,
        "casAppMetaDataOptions": {"balise": {
            "casAppMetaDataOptionsService": service, "casAppMetaDataOptionsUserAttribute": "uid",
            "casAppMetaDataOptionsLogout": 1,
        }},
        "casAppMetaDataExportedVars": {"balise": {name: name for name in PUPIL}},
        "issuerDBOpenIDConnectActivation": 1, "oidcServiceMetaDataIssuer": portal,
        "oidcServicePrivateKeySig": key.as_pem(private=True).decode(),
        "oidcServicePublicKeySig": key.as_pem(private=False).decode(), "oidcServiceKeyIdSig": "of-a-test",
        "oidcServiceAllowAuthorizationCodeFlow": 1,
        "oidcRPMetaDataOptions": {"balise": {f"oidcRPMetaDataOptions{name}": value for name, value in client.items()}},
        "oidcRPMetaDataExportedVars": {"balise": {"name": "cn", "groups": "roles;string;always"}},
        "oidcRPMetaDataOptionsExtraClaims": {"balise": {"groups": "groups"}},
    }  # fmt: skip
    (folder / "conf" / "lmConf-1.json").write_text(json.dumps(document))
    ini = folder / "lemonldap-ng.ini"
    ini.write_text(INI.format(folder=folder))
    return ini


@pytest.mark.skipif(not PORTAL.exists() or not shutil.which("plackup"), reason="LemonLDAP::NG is not installed")
def test_one_session_of_lemonldap_enters_by_cas_and_by_openid_connect(live: Server, data: Path, tmp_path: Path) -> None:
    port = free_port()
    portal = f"http://127.0.0.1:{port}"
    cas = register(data, Protocol.cas, {"name": "Portail", "issuer": f"{portal}/cas", "service": live.address})
    form = {"name": "Université", "issuer": portal, "client_id": "balise", "client_secret": "secret-of-a-test"}
    scopes = {"service": live.address, "scopes": "openid profile groups"}
    oidc = register(data, Protocol.oidc, {**form, **scopes}, GROUPS)
    cas_back, oidc_back = (f"{live.address}/connexion/etablissement/{provider}" for provider in (cas, oidc))
    ini = configure(tmp_path, portal, cas_back, oidc_back)
    serve = ["plackup", "--host", "127.0.0.1", "--port", str(port), "-E", "production", str(PORTAL)]
    command = ["env", f"LLNG_DEFAULTCONFFILE={ini}", *serve]
    with running(command, portal), httpx.Client(follow_redirects=True, timeout=PATIENCE) as client:
        page = client.get(f"{cas_back}?suite=/compte")
        assert 'name="password"' in page.text, page.text
        entered = submit(client, page, user="dwho", password="dwho")
        assert str(entered.url) == f"{live.address}/compte", entered.text
        assert "Doctor Who" in entered.text
        assert courses(data, cas) == ["2NDE5"]
        used = next(str(step.url) for step in entered.history if "ticket=" in str(step.url))
        assert client.get(used).status_code == 403

        other = client.get(f"{oidc_back}?suite=/compte")
        assert str(other.url) == f"{live.address}/compte", other.text
        assert courses(data, oidc) == ["L2 info"]
        used = next(str(step.url) for step in other.history if "code=" in str(step.url))
        assert client.get(used).status_code == 403

        described = client.get(f"{portal}/.well-known/openid-configuration").json()
        assert "none" in described["id_token_signing_alg_values_supported"], "the trap that is refused is here"
        people = [account.id for issuer in (f"{portal}/cas", portal) for account in read(data, arrived(issuer))]
        assert len(people) == 2
        mine = select(BrowserSession).where(BrowserSession.account_id.in_(people))
        assert len(read(data, mine)) == 2
        client.get(f"{portal}/?logout=1")
        until(lambda: len(read(data, mine)) == 1, "the session of CAS that the portal has ended")
        assert not described["backchannel_logout_supported"], "its end of the other session is to be tried here"
