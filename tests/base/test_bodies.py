"""Bodies of requests: bounded, announced, and whole."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from typing import Any

import pytest
from fastapi.routing import iter_route_contexts

from server.base.arrival import arrival_time
from server.base.middleware import BodyLimitMiddleware
from tests.support.service import Site

HOST = (b"host", b"testserver")


def ask(
    site: Site,
    method: str,
    headers: list[tuple[bytes, bytes]],
    *messages: dict[str, Any],
    path: str = "/api/v1/submissions",
) -> tuple[int, Any]:
    """Send ASGI messages; return the status and the problem document. More is never asked for than there is."""
    waiting, answers = iter(messages), []

    async def receive() -> Any:
        return next(waiting)

    async def send(message: Any) -> None:
        answers.append(message)

    scope = {
        "type": "http", "method": method, "path": path, "raw_path": path.encode(),
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
    bounded = BodyLimitMiddleware(app, most=100)
    with site.client._portal_factory() as portal:
        portal.call(bounded, scope, receive, None)
    assert arrivals == sorted(arrivals)


def test_a_body_that_is_cut_off_is_no_request(site: Site) -> None:
    begun = {"type": "http.request", "body": b'{"exercise":', "more_body": True}
    status, problem = ask(site, "POST", [(b"content-length", b"100")], begun, {"type": "http.disconnect"})
    assert status == 422
    assert "interrompue" in problem["detail"]


def form_of(count: int) -> bytes:
    return b"&".join(b"f%d=" % number for number in range(count))


@pytest.mark.parametrize("path", ["/connexion", "/classes/x/carnet/colonnes/x"])
def test_a_form_of_too_many_fields_is_refused_in_french_and_a_large_one_is_read(site: Site, path: str) -> None:
    """The marks of a column are three fields for each student of a class."""
    headers = {"Content-Type": "application/x-www-form-urlencoded", "Accept": "text/html"}
    answer = site.client.post(path, content=form_of(9_000), headers=headers)
    assert answer.status_code not in (400, 413)
    answer = site.client.post(path, content=form_of(10_100), headers=headers)
    assert answer.status_code == 413
    assert "plus de 10\u202f000 champs" in answer.text


def test_a_body_of_hundreds_of_names_is_refused_as_a_whole(site: Site) -> None:
    """An error for each of 30,000 unknown names took half a second."""
    body = {f"nom{number}": 1 for number in range(500)}
    answer = site.client.post("/api/v1/submissions", json=body, headers=site.token())
    assert answer.status_code == 422
    assert [each["detail"] for each in answer.json()["errors"]] == ["pas plus de 100 noms sont attendus"]


def test_half_a_request_is_none_at_any_address(site: Site) -> None:
    routes = [(path, method) for path, method in unsafe_routes(site) if "{" not in path]
    assert len(routes) > 10
    for path, method in routes:
        begun = {"type": "http.request", "body": b"a=", "more_body": True}
        length = [(b"content-length", b"100"), (b"accept", b"application/json")]
        status, problem = ask(site, method, length, begun, {"type": "http.disconnect"}, path=path)
        assert (status, "interrompue" in problem["detail"]) == (422, True), path


def unsafe_routes(site: Site) -> list[tuple[str, str]]:
    contexts = iter_route_contexts(site.app.routes)
    return [(route.path, method) for route in contexts for method in (route.methods or set()) - {"GET", "HEAD"}]
