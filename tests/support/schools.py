"""Servers of schools that are registered in a test, and stand-ins that answer for them."""

from __future__ import annotations

from typing import Any
from urllib.parse import parse_qs, urlsplit

from sqlalchemy import func, select

from server.base.app_services import get_service
from server.database import Database
from server.federation import registration
from server.federation.discovery import Discovery
from server.federation.models import IdentityProvider, Protocol
from server.federation.remote_keys import RemoteKeyCache
from server.federation.rules import OIDC_RULE
from server.federation.service import Federation
from tests.support.client import TestClient
from tests.support.issuer import CLIENT, ISSUER
from tests.support.service import Site

SERVICE, CAS = "http://testserver", "https://cas.ent.example/cas"
FORM = {"name": "Lycée", "service": SERVICE}


def add_server(database: Database, protocol: Protocol, *, opened: bool = True, **form: str) -> IdentityProvider:
    start = {"issuer": ISSUER if protocol == Protocol.oidc else CAS, "client_id": CLIENT, **FORM, **form}
    parse = registration.parse_oidc if protocol == Protocol.oidc else registration.parse_cas
    texts, settings = parse(start, insecure=True)
    with database.write() as db:
        added = registration.add_server(db, protocol, texts, settings, None, trusts=True)  # type: ignore[arg-type]
        if opened:
            added.paused_at = None
            added.settings = {**added.settings, "rule": OIDC_RULE.model_dump(mode="json")}
    return added


def stand_in(site: Site, system: Any) -> Any:
    """Have a system in memory answer in place of other machines."""
    federation = get_service(site.app, Federation)
    federation.outgoing, federation.keys, federation.discovery = system, RemoteKeyCache(system), Discovery(system)
    return system


def browser(site: Site, **cookies: str) -> TestClient:
    return TestClient(site.app, follow_redirects=False, cookies=cookies)


def query_of(address: str) -> dict[str, str]:
    return {name: values[0] for name, values in parse_qs(urlsplit(address).query).items()}


def path_of(address: str) -> str:
    return urlsplit(address).path + "?" + urlsplit(address).query


def count(site: Site, table: Any) -> int:
    with site.database.read() as db:
        return db.execute(select(func.count()).select_from(table)).scalar_one()
