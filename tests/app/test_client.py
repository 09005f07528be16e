"""The tests' own client of an application answers as Starlette's does."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import httpx
import pytest
from fastapi import BackgroundTasks, FastAPI, Request
from fastapi.responses import PlainTextResponse, RedirectResponse, Response, StreamingResponse
from starlette import testclient

from tests.support.client import TestClient

DONE: list[str] = []


def application() -> FastAPI:
    app = FastAPI()

    @app.get("/pieces")
    def pieces() -> StreamingResponse:
        return StreamingResponse(f"{k} " for k in range(3))

    @app.get("/ailleurs")
    def elsewhere() -> RedirectResponse:
        return RedirectResponse("/echo/été?a=1&b=%20")

    @app.get("/casse")
    def broken() -> None:
        raise ZeroDivisionError("for the test")

    @app.get("/trace")
    def behind(tasks: BackgroundTasks) -> PlainTextResponse:
        tasks.add_task(DONE.append, "done")
        return PlainTextResponse("bien")

    @app.api_route("/echo/{rest:path}", methods=["GET", "POST", "HEAD"])
    async def echo(request: Request, rest: str) -> Response:
        told = (
            f"{request.method} {request.url} {rest} {request.client} {await request.body()!r} {request.headers.items()}"
        )
        answer = PlainTextResponse(f"{told} {request.cookies}")
        answer.set_cookie("biscuit", "sec")
        return answer

    return app


def told(client: httpx.Client, method: str, path: str, body: bytes) -> object:
    answer = client.request(method, path, content=body, headers={"X-Un": "é".encode()})
    heads = sorted((name, value) for name, value in answer.headers.multi_items())
    return answer.status_code, str(answer.url), heads, answer.content, sorted(client.cookies.items())


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "/pieces"), ("HEAD", "/echo/"), ("GET", "/ailleurs"), ("GET", "/casse"), ("GET", "/trace"),
        ("POST", "/echo/a%2Fb/c d?x=%2B"), ("GET", "/nulle-part"), ("DELETE", "/echo/"),
    ],
)  # fmt: skip
def test_it_is_answered_the_same(method: str, path: str) -> None:
    app = application()
    DONE.clear()
    answers = [
        told(make(app, base_url="https://balise.test:8443", raise_server_exceptions=False), method, path, b"corps")
        for make in (testclient.TestClient, TestClient)
    ]
    assert answers[0] == answers[1]
    assert len(DONE) == 2 * (path == "/trace"), "what is left to do is done when the answer is there"


def test_what_breaks_is_raised_unless_it_is_asked_not_to() -> None:
    with pytest.raises(ZeroDivisionError, match="for the test"):
        TestClient(application()).get("/casse")


def test_what_is_streamed_comes_while_more_is_to_come() -> None:
    app, more = FastAPI(), threading.Event()

    def words() -> Iterator[str]:
        yield "un"
        assert more.wait(300), "the first word was to be read first"
        yield "deux"

    app.get("/")(lambda: StreamingResponse(words()))
    with TestClient(app) as client, client.stream("GET", "/") as answer:
        pieces = answer.iter_text()
        assert next(pieces) == "un"
        more.set()
        assert "".join(pieces) == "deux"


def test_all_clients_of_an_application_that_is_served_share_its_loop() -> None:
    app = FastAPI()

    @app.get("/")
    async def here() -> int:
        return threading.get_ident()

    with TestClient(app) as serving:
        threads = {client.get("/").json() for client in (serving, TestClient(app), TestClient(app))}
        assert len(threads) == 1
    aside = {TestClient(made).get("/").json() for made in (app, app)}
    assert len(aside) == 1
    assert aside != threads
