"""Replays of one launch, sent at once to a service that runs: one enters."""

from __future__ import annotations

import json
import re
import threading
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

import pytest
from sqlalchemy import func, select

from server.base.settings import Settings
from server.federation.lti import registration
from server.identity.models import BrowserSession, FederatedIdentity
from tests.support.live import PATIENCE, Live
from tests.support.platforms import CLIENT, Platform, private_key, sign
from tests.support.service import migrated

REPLAYS, AT_ONCE = 10_000, 64


class Keys(BaseHTTPRequestHandler):
    """The platform, which only publishes its keys."""

    def do_GET(self) -> None:
        self.send_response(200)
        self.end_headers()
        self.wfile.write(json.dumps({"keys": [private_key().as_dict(private=False)]}).encode())

    def log_message(self, *_: Any) -> None: ...


@pytest.fixture
def platform() -> Iterator[Platform]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Keys) as web:
        threading.Thread(target=web.serve_forever, daemon=True).start()
        yield Platform(f"http://127.0.0.1:{web.server_address[1]}")
        web.shutdown()


class Replayer:
    """A launch that a browser has begun, and the connections by which it arrives again and again."""

    def __init__(self, address: str, platform: Platform) -> None:
        self.host, self.threads = urlsplit(address).netloc, threading.local()
        hints = {"iss": platform.issuer, "client_id": CLIENT, "login_hint": "u", "target_link_uri": f"{address}/"}
        _, away, cookie = self._ask("GET", f"/lti/connexion?{urlencode(hints)}")
        (self.cookie,) = re.findall(r"balise_etat_\w+=[^;]+", cookie)
        _, asked, _ = self._ask("GET", away)
        query = dict(parse_qsl(urlsplit(asked).query))
        token = sign(platform.claims(query["nonce"], target_link_uri=f"{address}/"))
        self.form = urlencode({"state": query["state"], "id_token": token})

    cookie, form = "", ""

    def _ask(self, method: str, path: str) -> tuple[int, str, str]:
        if not hasattr(self.threads, "connection"):
            self.threads.connection = HTTPConnection(self.host, timeout=PATIENCE)
        headers = {"Content-Type": "application/x-www-form-urlencoded", "Cookie": self.cookie}
        self.threads.connection.request(method, path, self.form if method == "POST" else None, headers)
        answer = self.threads.connection.getresponse()
        answer.read()
        return answer.status, answer.getheader("location", ""), answer.getheader("set-cookie", "")

    def arrive(self, _: int) -> int:
        return self._ask("POST", "/lti/lancement")[0]


@pytest.mark.slow
def test_ten_thousand_replays_at_once_enter_once(both: Settings, platform: Platform) -> None:
    data: Path = both.data_dir
    database = migrated(both)
    texts = {"name": "Moodle", "issuer": platform.issuer, "client_id": CLIENT}
    with database.write() as db:
        registration.add_platform(db, texts, platform.settings, None)
    walls = {"BALISE_PLATFORM_HTTP": "1", "BALISE_PLATFORM_NETWORKS": "127.0.0.0/8", "BALISE_WORKERS": "1"}
    engine = {"BALISE_DATABASE_URL": both.database_url} if both.database_url else {}
    live = Live(data, **walls, **engine)
    try:
        replayer = Replayer(live.address, platform)
        with ThreadPoolExecutor(AT_ONCE) as threads:
            answers = Counter(threads.map(replayer.arrive, range(REPLAYS)))
        assert answers == {303: 1, 403: REPLAYS - 1}
        with database.read() as db:
            for table in (BrowserSession, FederatedIdentity):
                assert db.execute(select(func.count()).select_from(table)).scalar_one() == 1
    finally:
        live.process.terminate()
        live.process.wait(PATIENCE)
        live.close()
        database.close()
