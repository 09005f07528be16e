"""Bodies of requests: bounded, announced, and whole."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from typing import Any

import pytest

from server.base.arrival import arrival_time
from server.base.middleware import BoundedBody
from tests.support.service import Site

HOST = (b"host", b"testserver")


def ask(site: Site, method: str, headers: list[tuple[bytes, bytes]], *messages: dict[str, Any]) -> tuple[int, Any]:
    """Send ASGI messages; return the status and the problem document. More is never asked for than there is."""
    waiting, answers = iter(messages), []

    async def receive() -> Any:
        return next(waiting)

    async def send(message: Any) -> None:
        answers.append(message)

    scope = {
        "type": "http", "method": method, "path": "/api/v1/submissions", "raw_path": b"/api/v1/submissions",
        "query_string": b"", "headers": [HOST, *headers], "scheme": "http", "server": ("testserver", 80),
        "client": ("testclient", 1), "http_version": "1.1", "root_path": "", "asgi": {"version": "3.0"},
    }  # fmt: skip
    with site.client._portal_factory() as portal:
        portal.call(site.app, scope, receive, send)
    return answers[0]["status"], json.loads(b"".join(answer.get("body", b"") for answer in answers))


@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "DELETE"])
def test_a_body_of_unannounced_length_is_refused_before_it_is_read(site: Site, method: str) -> None:
    status, problem = ask(site, method, [(b"transfer-encoding", b"chunked")])
    assert status == 411
    assert problem["type"].endswith("longueur-inconnue")


def test_the_arrival_is_when_the_whole_body_is_there(site: Site) -> None:
    arrivals = []

    async def receive() -> Any:
        arrivals.append(datetime.now(UTC))
        return {"type": "http.request", "body": b"x", "more_body": len(arrivals) < 3}

    async def app(scope: Any, receive: Any, send: Any) -> None:
        arrivals.append(arrival_time())
        arrivals.append(datetime.now(UTC))

    scope = {"type": "http", "method": "POST", "path": "/", "headers": []}
    bounded = BoundedBody(app, most=100, refuse=lambda request, error: pytest.fail(str(error)))
    with site.client._portal_factory() as portal:
        portal.call(bounded, scope, receive, None)
    assert arrivals == sorted(arrivals)


def test_a_body_that_is_cut_off_is_no_request(site: Site) -> None:
    begun = {"type": "http.request", "body": b'{"exercise":', "more_body": True}
    status, problem = ask(site, "POST", [(b"content-length", b"100")], begun, {"type": "http.disconnect"})
    assert status == 422
    assert "interrompue" in problem["detail"]
