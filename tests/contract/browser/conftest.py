"""A real `balise serve` and a real browser. Every page is watched: no error, no refused content, no other site."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

import pytest

from server.base.http import SESSION_COOKIE
from server.database import Database, utc_now
from server.identity.models import Account, BrowserSession
from server.identity.secrets import draw_secret_token, sha256_hex
from tests.support.chromium import chromium
from tests.support.served import Server

if TYPE_CHECKING:
    from playwright.sync_api import BrowserType, ConsoleMessage, Request

sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
Browser, Page = sync_api.Browser, sync_api.Page
sync_api.expect.set_options(timeout=180_000)

log = logging.getLogger(__name__)
ROOT = Path(__file__).parents[3]
#: One process shows all pages and another draws them: starting one for each page is a third of what a page costs.
OPTIONS = (
    "--no-sandbox",
    "--in-process-gpu",
    "--renderer-process-limit=1",
    "--disable-site-isolation-trials",
    "--process-per-site",
)
EXERCISE = "/l20/exercices/poses"
#: A browser of the machine dies at its start once in some hundred: all tests of a process would fail by it.
LAUNCHES = 3


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    program = chromium()
    if program is None:
        pytest.skip("no Chromium on this machine")
    with sync_api.sync_playwright() as playwright:
        launched = _launch(playwright.chromium, program)
        yield launched
        launched.close()


def _launch(chromium_type: BrowserType, program: str) -> Browser:
    """Start the browser, again where it dies at once."""
    for _ in range(LAUNCHES - 1):
        try:
            return chromium_type.launch(executable_path=program, args=OPTIONS)
        except sync_api.Error as error:
            log.warning("the browser died at its start: %s", error.message)
    return chromium_type.launch(executable_path=program, args=OPTIONS)


@dataclass
class Visit:
    """One visitor's page, and what went wrong on it."""

    page: Page
    server: Server
    faults: list[str]

    def open(self, path: str = EXERCISE) -> Page:
        self.page.goto(self.server.address + path)
        if path.startswith(EXERCISE):
            self.page.wait_for_selector("html.has-editor")
        return self.page

    def write(self, code: str) -> None:
        """Replace what the editor holds, as pasting does."""
        self.page.locator(".cm-content").click()
        self.page.keyboard.press("Control+a")
        self.page.evaluate("text => navigator.clipboard.writeText(text)", code)
        self.page.keyboard.press("Control+v")

    def verdict(self, kind: str = "done", patience: int = 180) -> None:
        """Wait until a verdict stands that was not there before; `patience` in seconds."""
        self.page.wait_for_selector(f"[data-part=verdict][data-status={kind}]", timeout=1000 * patience)

    def submit(self, code: str, patience: int = 180) -> None:
        self.write(code)
        self.page.evaluate("document.querySelector('[data-part=verdict]').dataset.status = 'old'")
        self.page.keyboard.press("Control+Enter")
        self.verdict(patience=patience)


NewVisit = Callable[..., Visit]


def enters(visitor: Visit, database: Database, account: Account) -> Visit:
    """Signs in by a session written in the server's own database."""
    cookie = draw_secret_token()
    with database.write() as db:
        ends = utc_now().replace(year=2100)
        db.add(BrowserSession(token_digest=sha256_hex(cookie), account_id=account.id, expires_at=ends))
    visitor.page.context.add_cookies([{"name": SESSION_COOKIE, "value": cookie, "url": visitor.server.address}])
    return visitor


@pytest.fixture
def visit(browser: Browser, server: Server, request: pytest.FixtureRequest) -> Iterator[NewVisit]:
    """Makes visitors, each with cookies of their own; `expected` is a pattern of what a test provokes on purpose.

    They ask for still pages, which are not drawn sixty times a second while one waits, but where a file says `MOVES`.
    """
    motion = "no-preference" if getattr(request.module, "MOVES", False) else "reduce"
    opened: list[tuple[Visit, str]] = []

    def make(
        *, width: int = 1280, height: int = 800, expected: str = "(?!)", at: Server = server, **options: object
    ) -> Visit:
        context = browser.new_context(
            viewport={"width": width, "height": height},
            locale="fr-FR",
            permissions=["clipboard-read", "clipboard-write"],
            **{"reduced_motion": motion, **options},
        )
        page = context.new_page()
        page.set_default_timeout(180_000)
        made = Visit(page, at, [])
        _watch(made)
        opened.append((made, expected))
        return made

    yield make
    for one, expected in opened:
        one.page.context.close()
        assert [fault for fault in one.faults if not re.search(expected, fault)] == []


def _watch(visit: Visit) -> None:
    host = urlsplit(visit.server.address).netloc
    note = visit.faults.append

    def request(sent: Request) -> None:
        if not sent.url.startswith(("data:", "blob:")) and urlsplit(sent.url).netloc != host:
            note(f"remote request: {sent.url}")

    def console(message: ConsoleMessage) -> None:
        if message.type in {"error", "warning"}:
            note(f"console: {message.text}")

    visit.page.on("request", request)
    visit.page.on("console", console)
    visit.page.on("pageerror", lambda error: note(f"script: {error}"))
