"""The answers of the HTTP interface conform to its OpenAPI document."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator

import pytest
import uvicorn

from server.app import create_app
from server.base import http_protocol
from server.base.settings import Settings
from server.course import Course
from server.database import Database
from tests.api.test_api import Drawer, draws
from tests.support.service import Site


@pytest.fixture
def address(sqlite: Database, settings: Settings, course: Course) -> Iterator[str]:
    """The application behind a real socket, in a thread."""
    app = create_app(settings.model_copy(update={"submission_refill_seconds": 0.0}), course=course)
    draws(app, Drawer())
    server = uvicorn.Server(http_protocol.uvicorn_config(app, grace=1))
    listener = socket.create_server(("127.0.0.1", 0))
    thread = threading.Thread(target=server.run, args=([listener],))
    thread.start()
    while not server.started:
        assert thread.is_alive()
        time.sleep(0.01)
    yield f"http://127.0.0.1:{listener.getsockname()[1]}"
    server.should_exit = True
    thread.join()


@pytest.mark.parametrize("mode", ["positive", "negative"])
def test_the_answers_conform_to_the_document(
    site: Site, address: str, mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Schemathesis, bounded: whatever is sent, fitting or not, the answer is one that the document announces."""
    from tests.contract.api.conformance import conforms, operations  # slow to import

    monkeypatch.setattr("server.api.submissions.LONGEST_WAIT", 0.01)  # nobody grades here
    headers = site.token()
    sent = site.submit(headers)
    site.worker.run_one()
    known = {"submission_id": sent["id"], "module": "l20", "slug": "poses", "name": "b"}
    for operation in operations(f"{address}/api/v1/openapi.json"):
        conforms(operation, mode, known, headers, examples=2)
        if "{" in operation.path and mode == "positive":  # what is named is nowhere: one answer, whatever is sent
            conforms(operation, mode, {}, headers, examples=1)
