"""The first reading of a text, a search's index, an archive: whoever waits for it takes no thread from the pages."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import Any

import anyio.to_thread
import pytest
from starlette.types import Message

from server.base import turns
from server.reading import downloads, search
from server.text.markup import MarkdownText
from tests.support.service import Site

#: More than there are threads for pages.
CROWD = 60


async def ask(app: Any, path: str) -> int:
    messages: list[Message] = []

    async def receive() -> Message:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Message) -> None:
        messages.append(message)

    scope = {
        "type": "http", "method": "GET", "path": path, "raw_path": path.encode(), "query_string": b"q=robot",
        "headers": [(b"host", b"testserver")], "scheme": "http", "server": ("testserver", 80),
        "client": ("testclient", 1), "http_version": "1.1", "root_path": "", "asgi": {"version": "3.0"},
    }  # fmt: skip
    await app(scope, receive, send)
    return int(messages[0]["status"])


@pytest.fixture
def gate(monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Until it is set, whoever makes something that is slow waits."""
    opened = threading.Event()

    def waiting(work: Callable[..., Any]) -> Callable[..., Any]:
        def wait_and_work(*arguments: Any) -> Any:
            assert opened.wait(60)
            return work(*arguments)

        return wait_and_work

    monkeypatch.setattr(turns, "TURN_SECONDS", 600)  # nobody's turn ends by itself: all of the crowd come to wait
    monkeypatch.setattr(MarkdownText, "is_rendered", property(lambda _text: opened.is_set()))
    monkeypatch.setattr(MarkdownText, "rendered", property(waiting(lambda text: text.__dict__["rendered"])))
    monkeypatch.setattr(search, "_indexes", {})
    monkeypatch.setattr(search, "SearchIndex", waiting(search.SearchIndex))
    monkeypatch.setattr(downloads, "import_file", waiting(downloads.import_file))
    return opened


@pytest.mark.parametrize(
    "path",
    ["/l20/lire/localiser", "/l20/exercices/poses", "/l20/glossaire", "/l20/recherche", "/l20/fichiers/parcours.zip"],
)
def test_a_crowd_of_first_readers_leaves_the_pages_to_the_others(site: Site, gate: threading.Event, path: str) -> None:
    async def scene() -> None:
        limiter = anyio.to_thread.current_default_thread_limiter()
        crowd = [asyncio.create_task(ask(site.app, path)) for _ in range(CROWD)]
        for _ in range(200):
            await asyncio.sleep(0)
        while limiter.borrowed_tokens:
            await asyncio.sleep(0.001)
        assert not any(task.done() for task in crowd)
        assert await ask(site.app, "/connexion") == 200
        for task in crowd:
            task.cancel()
        gate.set()
        await asyncio.gather(*crowd, return_exceptions=True)

    with site.client._portal_factory() as portal:
        portal.call(scene)
