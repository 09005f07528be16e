"""HEAD is answered as GET is, without the body."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest

from server.base.middleware import HeadAsGetMiddleware
from tests.support.coroutines import run_apart
from tests.support.service import EXERCISE, Site

MODULE = EXERCISE.split("/")[0]


@pytest.mark.parametrize(
    "path", ["/", f"/{MODULE}", "/healthz", "/readyz", "/nulle-part", "/api/v1/openapi.json", "/compte", "/static/x"]
)
def test_head_has_the_status_and_headers_of_get(site: Site, path: str) -> None:
    head, get = site.client.head(path), site.client.get(path)
    assert head.status_code == get.status_code
    assert not head.content
    assert head.headers.get("content-type") == get.headers.get("content-type")
    assert head.headers.get("location") == get.headers.get("location")


def test_head_does_not_do_what_post_does(site: Site) -> None:
    assert site.client.head("/deconnexion").status_code == site.client.get("/deconnexion").status_code == 405


def test_a_stream_is_told_that_its_reader_has_left() -> None:
    sent: list[dict[str, Any]] = []

    async def stream(scope: Any, receive: Any, send: Any) -> None:
        assert scope["method"] == "GET"
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b"a", "more_body": True})
        assert (await receive())["type"] == "http.disconnect"

    async def record(message: Any) -> None:
        sent.append(message)

    async def never() -> Any:
        await asyncio.Event().wait()

    run_apart(HeadAsGetMiddleware(stream)({"type": "http", "method": "HEAD"}, never, record))
    assert [message["type"] for message in sent] == ["http.response.start", "http.response.body"]
    assert not sent[1]["body"]
