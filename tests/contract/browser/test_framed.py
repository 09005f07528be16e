"""A launch in the frame of a platform's page, in a real browser that blocks third-party cookies, up to a verdict."""

from __future__ import annotations

import html
import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qsl, quote, urlsplit

import pytest

from server.federation.lti import registration
from server.federation.lti.schemas import LtiSettings
from tests.contract.browser.conftest import Browser
from tests.support.platforms import CLIENT, DEPLOYMENT, Platform, private_key, sign
from tests.support.quick import the_course
from tests.support.served import Server

EXERCISE = "/l20/exercices/poses"
BLOCKED = {
    "enableThirdPartyCookieRestriction": True,
    "disableThirdPartyCookieMetadata": True,
    "disableThirdPartyCookieHeuristics": True,
}


class Handler(BaseHTTPRequestHandler):
    """The platform: a page with a frame, its authentication, which answers by a form, and its keys."""

    platform: Platform
    service: str

    def do_GET(self) -> None:
        parts = urlsplit(self.path)
        query = dict(parse_qsl(parts.query))
        if parts.path == "/certs.php":
            return self._answer(json.dumps({"keys": [private_key().as_dict(private=False)]}), "application/json")
        if parts.path == "/auth.php":
            claims = self.platform.claims(query["nonce"], target_link_uri=self.service + EXERCISE)
            fields = {"state": query["state"], "id_token": sign(claims)}
            inputs = "".join(f'<input name="{name}" value="{html.escape(value)}">' for name, value in fields.items())
            form = f'<form method="post" action="{query["redirect_uri"]}">{inputs}</form>'
            return self._answer(f"{form}<script>document.forms[0].submit()</script>")
        target = quote(self.service + EXERCISE, safe="")
        begin = f"{self.service}/lti/connexion?iss={quote(self.platform.issuer, safe='')}&client_id={CLIENT}"
        frame = html.escape(f"{begin}&login_hint=1&target_link_uri={target}")
        self._answer(f'<h1>Cours</h1><iframe src="{frame}" width="1000" height="700"></iframe>')

    def _answer(self, body: str, kind: str = "text/html; charset=utf-8") -> None:
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.end_headers()
        self.wfile.write(body.encode())

    def log_message(self, *_: Any) -> None: ...


@pytest.fixture(scope="module")
def school(server: Server) -> Iterator[tuple[Server, str]]:
    """Serve a platform at localhost, and register it with Balise at 127.0.0.1: two sites."""
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as web:
        threading.Thread(target=web.serve_forever, daemon=True).start()
        platform = Platform(f"http://localhost:{web.server_address[1]}")
        _register(server, platform)
        Handler.platform, Handler.service = platform, server.address
        yield server, platform.issuer
        web.shutdown()


def _register(server: Server, platform: Platform) -> None:
    database = server.open_database()
    settings: LtiSettings = platform.settings
    texts = {"name": "Moodle", "issuer": platform.issuer, "client_id": CLIENT}
    with database.write() as db:
        registration.add_platform(db, texts, settings, None)
    database.close()
    assert settings.deployments == (DEPLOYMENT,)


@pytest.mark.parametrize("blocked", [True, False], ids=["third-party cookies blocked", "allowed"])
def test_a_student_gets_a_verdict_in_the_frame_of_the_course(
    browser: Browser, school: tuple[Server, str], blocked: bool
) -> None:
    server, course = school
    with browser.new_context(locale="fr-FR") as context:
        page = context.new_page()
        page.set_default_timeout(180_000)
        page.goto("about:blank")
        if blocked:
            controls = page.context.new_cdp_session(page)
            controls.send("Network.enable")
            controls.send("Network.setCookieControls", BLOCKED)
        page.goto(course)
        page.reload()  # the controls hold from the second page on
        frame = page.frame_locator("iframe")
        frame.get_by_role("link", name="Ada Lovelace").wait_for()
        cookies = [cookie["name"] for cookie in page.context.cookies(server.address)]
        assert "balise_cadre" in cookies
        frame.locator(".cm-content").click()
        page.keyboard.press("Control+a")
        page.keyboard.type(the_course().exercises["l20/poses"].starter[:40])
        page.keyboard.press("Control+Enter")
        frame.locator("[data-part=verdict][data-status=done]").wait_for()
