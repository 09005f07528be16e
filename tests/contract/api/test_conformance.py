"""The answers of the HTTP interface conform to its OpenAPI document."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from typing import Any, cast

import httpx2 as httpx
import pytest
import uvicorn

from server.base import http_protocol
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from tests.api.test_api import Drawer, draws
from tests.support.live import PATIENCE
from tests.support.quick import standing_app
from tests.support.service import Site


@pytest.fixture
def served(sqlite: Database, settings: Settings, course: Course) -> Iterator[Site]:
    """The application behind a real socket, in a thread."""
    told = settings.model_copy(update={"submission_refill_seconds": 0.0})
    app = standing_app(told, course)
    draws(app, Drawer())
    server = uvicorn.Server(http_protocol.uvicorn_config(app, grace=1))
    listener = socket.create_server(("127.0.0.1", 0))
    thread = threading.Thread(target=server.run, args=([listener],))
    thread.start()
    while not server.started:
        assert thread.is_alive()
        time.sleep(0.01)
    with httpx.Client(base_url=f"http://127.0.0.1:{listener.getsockname()[1]}", timeout=PATIENCE) as client:
        yield Site(app, cast(Any, client), told)
    server.should_exit = True
    thread.join()


def test_the_answers_conform_to_the_document(served: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    """Schemathesis, bounded: whatever is sent, fitting or not, the answer is one that the document announces."""
    from tests.contract.api.conformance import conforms, operations  # slow to import

    monkeypatch.setattr("server.api.submissions.LONGEST_WAIT", 0.01)  # nobody grades here
    headers = served.token()
    sent = served.submit(headers)
    served.worker.run_one()
    known = {"submission_id": sent["id"], "module": "l20", "slug": "poses", "name": "b"}
    for operation in operations(str(served.client.base_url.join("/api/v1/openapi.json"))):
        for mode in ("positive", "negative"):
            conforms(operation, mode, known, headers, examples=2)
        if "{" in operation.path:  # what is named is nowhere: one answer, whatever is sent
            conforms(operation, "positive", {}, headers, examples=1)
