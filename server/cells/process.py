"""The process that runs cells for the service: it owns a sandbox, and is the only one to read what comes out of it.

It is told the kits first, then one question a frame; it ends when the service closes the line, and dies with it.
"""

from __future__ import annotations

import gc
import json
import logging
import os
import signal
import socket
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from server.cells import wire
from server.cells.run import POLICY, run
from server.sandbox import Sandbox, SandboxFault
from server.sandbox.install import DRAWING

log = logging.getLogger(__name__)
#: Cells leave the processors to graders, pages and whoever else has something to do.
NICE = 5


class Line:
    """The service's end of the line, for several threads."""

    def __init__(self, end: socket.socket) -> None:
        self._end, self._sending = end, threading.Lock()

    def questions(self) -> Iterator[tuple[int, Any]]:
        """Number and content of each question, until the service has nothing more to ask."""
        with self._end.makefile("rb") as stream:
            while len(header := stream.read(wire.HEADER.size)) == wire.HEADER.size:
                length, number, _ = wire.HEADER.unpack(header)
                yield number, json.loads(stream.read(length))

    def answer(self, number: int, status: int, payload: bytes) -> None:
        with self._sending:
            self._end.sendall(wire.framed(number, status, payload))


def serve(end: socket.socket) -> None:
    """Until the line is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the service, which ends us
    os.nice(NICE)
    line = Line(end)
    questions = line.questions()
    _, beginning = next(questions)
    gc.freeze()
    with Sandbox(beginning["kits"], POLICY) as sandbox:
        threading.Thread(target=_warm, args=(sandbox,), name="warm-up", daemon=True).start()
        pool = ThreadPoolExecutor(beginning["at_once"], thread_name_prefix="cell")
        for number, question in questions:
            pool.submit(_answer, line, sandbox, number, question)
        pool.shutdown(wait=False, cancel_futures=True)


def _warm(sandbox: Sandbox) -> None:
    """Cells that draw and cells that do not follow one another. What fails here is told when a cell meets it."""
    for imports in ("numpy", DRAWING):
        try:
            sandbox.warm(imports)
        except (SandboxFault, RuntimeError):  # the second where it is being closed
            log.info("the %s template did not start", imports, exc_info=True)


def _answer(line: Line, sandbox: Sandbox, number: int, question: dict[str, str]) -> None:
    try:
        shown = run(sandbox, question["module"], question["code"].encode())
    except Exception:
        log.exception("a cell of %s could not be run", question["module"])
        line.answer(number, wire.FAILED, b"")
    else:
        line.answer(number, wire.DONE, shown.model_dump_json().encode())
