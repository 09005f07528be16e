"""Logs: lines of text, or one JSON object per line, with the id of the request.

They never hold what a student writes, nor an address: only names from the code, counts and times.
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

#: Events from the request to its verdict; logged in JSON only.
event_log = logging.getLogger("balise")
_request: ContextVar[str] = ContextVar("request", default="")


def new_request_id() -> str:
    return secrets.token_hex(8)


def current_request_id() -> str:
    """Return the id of the current request; empty outside of requests."""
    return _request.get()


@contextmanager
def request_context(request: str) -> Iterator[None]:
    """Log with the id of this request within the block."""
    token = _request.set(request)
    try:
        yield
    finally:
        _request.reset(token)


def log_event(message: str, **fields: object) -> None:
    """Log an event with structured fields."""
    event_log.info(message, extra={"fields": fields})


class JsonLines(logging.Formatter):
    """A record as a JSON object: `time`, `level`, `process`, `logger`, `message`, `request` if any, and more."""

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
    """Keeps the latest errors of this process: time, logger and first line. Thread-safe."""

    def __init__(self, max_errors: int = 8) -> None:
        super().__init__(logging.ERROR)
        self._latest: deque[tuple[datetime, str, str]] = deque(maxlen=max_errors)

    def emit(self, record: logging.LogRecord) -> None:
        line = record.getMessage().partition("\n")[0][:LONGEST]
        self._latest.append((datetime.fromtimestamp(record.created, UTC), record.name, line))

    def latest(self) -> list[tuple[datetime, str, str]]:
        return list(self._latest)


RECENT_ERRORS = RecentErrors()


def configure_logging(process: str, form: str, level: int = logging.WARNING) -> None:
    """Configure logging at the start of a process. `form` is TEXT or JSON."""
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
