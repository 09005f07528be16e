"""Logs: lines for people, or one JSON object a line for programs, each with the request that it comes from.

What a student writes and where they are is never in them: what is logged is names of ours, counts and times.
"""

from __future__ import annotations

import json
import logging
import re
import secrets
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime

TEXT, JSON = "text", "json"
LONGEST = 200
REQUEST_ID_PATTERN = re.compile(r"[A-Za-z0-9._-]{8,64}")

#: The trail of what was asked, from the request to its verdict: told in JSON alone.
event_log = logging.getLogger("balise")
_request: ContextVar[str] = ContextVar("request", default="")


def new_request_id() -> str:
    return secrets.token_hex(8)


def current_request_id() -> str:
    """The request that this is done for; empty for what nobody asked for."""
    return _request.get()


@contextmanager
def request_context(request: str) -> Iterator[None]:
    """What is logged within is of this request."""
    token = _request.set(request)
    try:
        yield
    finally:
        _request.reset(token)


def log_event(message: str, **fields: object) -> None:
    """One step of the trail, with what a program may look for."""
    event_log.info(message, extra={"fields": fields})


class JsonLines(logging.Formatter):
    """A record as an object: `time`, `level`, `process`, `logger`, `message`, `request` if any, and its own fields."""

    def __init__(self, process: str) -> None:
        super().__init__()
        self._process = process

    def format(self, record: logging.LogRecord) -> str:
        line: dict[str, object] = {
            "time": datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds"),
            "level": record.levelname.lower(),
            "process": self._process,
            "logger": record.name,
            "message": record.getMessage(),
        }
        if request := current_request_id():
            line["request"] = request
        line.update(getattr(record, "fields", {}))
        if record.exc_info:
            line["exception"] = self.formatException(record.exc_info)
        return json.dumps(line, ensure_ascii=False, default=str)


class RecentErrors(logging.Handler):
    """The latest errors of this process: when, of which logger, and their first line. For several threads."""

    def __init__(self, most: int = 8) -> None:
        super().__init__(logging.ERROR)
        self._latest: deque[tuple[datetime, str, str]] = deque(maxlen=most)

    def emit(self, record: logging.LogRecord) -> None:
        line = record.getMessage().partition("\n")[0][:LONGEST]
        self._latest.append((datetime.fromtimestamp(record.created, UTC), record.name, line))

    def latest(self) -> list[tuple[datetime, str, str]]:
        return list(self._latest)


RECENT_ERRORS = RecentErrors()


def configure_logging(process: str, form: str, level: int = logging.WARNING) -> None:
    """What a process does first. `form` is TEXT or JSON."""
    handler = logging.StreamHandler()
    named = f" {process}" if process else ""
    handler.setFormatter(
        JsonLines(process or "web")
        if form == JSON
        else logging.Formatter(f"%(asctime)s %(levelname)s{named} %(name)s: %(message)s")
    )
    logging.basicConfig(level=level, handlers=[handler, RECENT_ERRORS])
    logging.captureWarnings(form == JSON)
    event_log.setLevel(logging.INFO if form == JSON else logging.WARNING)
