"""The address of the cells: who may, how much, and what is answered when nothing can be run."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import httpx
import pytest
from starlette.types import Message

from server.base.app_services import app_service, get_service
from server.base.errors import InternalFailure, Overloaded
from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.cells.supervisor import CellRunner
from tests.support.client import TestClient
from tests.support.quick import in_a_loop
from tests.support.service import Site

ADDRESS = "/l20/cellules"
JSON = {"Accept": "application/json"}


def post(site: Site, code: Any = "print(1)", path: str = ADDRESS, **headers: str) -> httpx.Response:
    content = json.dumps({"code": code})  # the client's own encoder refuses half a character
    return site.client.post(path, content=content, headers={**JSON, "Content-Type": "application/json", **headers})


class Echo:
    """Cells that are not run: each is answered at once."""

    def __init__(self, raises: Exception | None = None) -> None:
        self.raises, self.asked = raises, []

    async def run_cell(self, module: str, code: str, *, reader: str, flow: str, rank: int = 0) -> bytes:
        self.asked.append((module, code))
        if self.raises:
            raise self.raises
        return b'{"stdout": ""}'


@pytest.fixture
def play(site: Site) -> Callable[[Echo], Echo]:
    def put(cells: Echo) -> Echo:
        site.app.dependency_overrides[app_service(CellRunner)] = lambda: cells
        return cells

    return put


def test_a_visitor_becomes_a_guest_and_gets_what_the_cell_shows(site: Site) -> None:
    answer = post(site, "import matplotlib.pyplot as plt\nprint(H)\nplt.plot([1])\n1 / 0")
    assert (answer.status_code, answer.headers["content-type"]) == (200, "application/json")
    assert answer.headers["cache-control"] == "no-store"
    assert SESSION_COOKIE in answer.cookies
    shown = answer.json()
    assert set(shown) == {"stdout", "truncated", "fault", "figures", "milliseconds"}
    assert (shown["stdout"], shown["truncated"], shown["fault"]["line"]) == ("16\n", False, 4)
    assert SESSION_COOKIE not in post(site).cookies, "the same guest"
    shown = post(site, "import matplotlib.pyplot as plt\nplt.plot([1])").json()
    assert shown["fault"] is None
    assert [one[:22] for one in shown["figures"]] == ["data:image/png;base64,"]


def refused(answer: httpx.Response, status: int) -> dict[str, Any]:
    problem: dict[str, Any] = answer.json()
    assert (answer.status_code, problem["status"]) == (status, status)
    assert answer.headers["content-type"] == "application/problem+json"
    return problem


def test_what_does_not_fit_is_refused_as_a_problem(site: Site, play: Callable[[Echo], Echo]) -> None:
    cells = play(Echo())
    refused(post(site, path="/l99/cellules"), 404)
    refused(post(site, "x" * (site.settings.code_bytes + 1)), 413)
    refused(post(site, "x" * (site.settings.body_bytes + 1)), 413)
    refused(post(site, 12), 422)
    refused(post(site, "\ud800"), 422)
    refused(site.client.post(ADDRESS, json={"code": "1", "module": "l19"}, headers=JSON), 422)
    refused(site.client.post(ADDRESS, content=b"{", headers={**JSON, "Content-Type": "application/json"}), 422)
    refused(site.client.get(ADDRESS, headers=JSON), 405)
    assert cells.asked == []
    assert post(site, "a\r\nb").status_code == 200
    assert cells.asked == [("l20", "a\nb")]


def test_another_site_runs_nothing(site: Site, play: Callable[[Echo], Echo]) -> None:
    cells = play(Echo())
    for headers in ({"Sec-Fetch-Site": "cross-site"}, {"Origin": "https://ailleurs.example"}):
        refused(post(site, **headers), 403)
    plain = site.client.post(ADDRESS, content=json.dumps({"code": "1"}), headers={**JSON, "Content-Type": "text/plain"})
    refused(plain, 422)
    assert cells.asked == []


def test_runs_are_counted_by_account(
    sqlite: object, settings: Settings, site: Site, play: Callable[[Echo], Echo]
) -> None:
    play(Echo())
    site.tighten(cell_burst=2)
    assert [post(site).status_code for _ in range(2)] == [200, 200]
    answer = post(site)
    assert "possible dans" in refused(answer, 429)["detail"]
    assert int(answer.headers["Retry-After"]) >= 1
    somebody = replace(site, client=TestClient(site.client.app))
    assert post(somebody).status_code == 200


@pytest.mark.parametrize(
    ("error", "status", "slug"),
    [
        (Overloaded("Beaucoup de monde.", retry_after=5), 503, "trop-de-monde"),
        (InternalFailure("Réessayez."), 500, "incident"),
    ],
)
def test_a_cell_that_was_not_run_is_told_and_does_not_count(
    site: Site, settings: Settings, play: Callable[[Echo], Echo], error: Exception, status: int, slug: str
) -> None:
    site.tighten(cell_burst=1)
    play(Echo(error))
    for _ in range(3):
        assert refused(post(site), status)["type"].endswith(slug)
    play(Echo())
    assert post(site).status_code == 200


def test_a_reader_who_leaves_leaves_the_queue(site: Site, play: Callable[[Echo], Echo]) -> None:
    """The application is called as a server does, with a reader who closes the page while the cell waits."""
    begun, ended = asyncio.Event(), asyncio.Event()

    class Endless(Echo):
        async def run_cell(self, module: str, code: str, *, reader: str, flow: str, rank: int = 0) -> bytes:
            begun.set()
            try:
                await asyncio.sleep(600)
            finally:
                ended.set()
            return b""

    play(Endless())
    body = json.dumps({"code": "1"}).encode()
    coming: list[Message] = [{"type": "http.request", "body": body}, {"type": "http.disconnect"}]

    async def receive() -> Message:
        if len(coming) == 1:
            await asyncio.wait_for(begun.wait(), 300)
        return coming.pop(0)

    async def send(_: Message) -> None:
        return None

    async def call() -> None:
        headers = [(b"content-type", b"application/json"), (b"accept", b"application/json")]
        scope = {"type": "http", "method": "POST", "path": ADDRESS, "raw_path": ADDRESS.encode(), "query_string": b""}
        scope |= {
            "headers": headers,
            "scheme": "http",
            "http_version": "1.1",
            "client": ("1.2.3.4", 5),
            "root_path": "",
        }
        await site.client.app(scope, receive, send)
        await asyncio.wait_for(ended.wait(), 300)

    in_a_loop(call())


def test_no_process_is_started_before_the_first_cell(site: Site) -> None:
    cells = get_service(site.app, CellRunner)
    assert site.client.get("/l20").status_code == 200
    assert cells.helper._process is None
