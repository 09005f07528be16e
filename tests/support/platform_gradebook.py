"""The gradebook of a platform that fails as real ones do: it answers 500, 409 and 429, and loses answers."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from random import Random
from typing import Any
from urllib.parse import parse_qs, urlsplit

from server.federation.errors import OutgoingError

Answer = tuple[int, Mapping[str, str], bytes]
FAULTS = ("before", "after", "lost", "slow", "busy")


@dataclass
class PlatformGradebook:
    """Line items and marks, with whole seconds of timestamps as Moodle compares them. `fault_rate` is of requests."""

    fault_rate: float = 0.0
    random: Random = field(default_factory=lambda: Random(3))
    items: dict[str, dict[str, Any]] = field(default_factory=dict)
    marks: dict[tuple[str, str], float | None] = field(default_factory=dict)
    seen_at: dict[tuple[str, str], int] = field(default_factory=dict)
    strangers: set[str] = field(default_factory=set)
    statuses: list[int] = field(default_factory=list)
    scores: list[Mapping[str, Any]] = field(default_factory=list)
    page_size: int = 2

    def handle(self, method: str, url: str, headers: Mapping[str, str], content: bytes) -> Answer:
        fault = self.random.choice(FAULTS) if self.random.random() < self.fault_rate else ""
        status, more, document = self._faulty(fault) if fault in {"before", "slow", "busy"} else (0, {}, None)
        if not status:
            status, more, document = self._answer(method, url, headers, content)
            if fault == "lost":
                raise OutgoingError("pas de réponse à temps", retry=True)
            if fault == "after":
                status, document = 500, {}
        self.statuses.append(status)
        return status, more, json.dumps(document).encode()

    @staticmethod
    def _faulty(fault: str) -> tuple[int, Mapping[str, str], Any]:
        if fault == "busy":
            return 429, {"retry-after": "2"}, {}
        return (500 if fault == "before" else 503), {}, {}

    def _answer(
        self, method: str, url: str, headers: Mapping[str, str], content: bytes
    ) -> tuple[int, Mapping[str, str], Any]:
        if headers.get("Authorization") != "Bearer jeton":
            return 401, {}, {}
        parts, body = urlsplit(url), json.loads(content or b"null")
        if parts.path.endswith("/scores"):
            return self._score(parts.path.removesuffix("/scores"), body)
        if method == "POST":
            return self._create(f"{parts.scheme}://{parts.netloc}", body)
        return self._list(url)

    def _create(self, origin: str, body: dict[str, Any]) -> tuple[int, Mapping[str, str], Any]:
        path = f"/items/{len(self.items)}"
        item = {**body, "id": f"{origin}{path}?type_id=3"}
        self.items[path] = item
        return 201, {}, item

    def _list(self, url: str) -> tuple[int, Mapping[str, str], Any]:
        """Return one page, of all items: the filter is not known here."""
        start = int(parse_qs(urlsplit(url).query).get("from", ["0"])[-1])
        rows = list(self.items.values())
        after = start + self.page_size
        more = {"link": f'<{url}&from={after}>; rel="next"'} if after < len(rows) else {}
        return 200, more, rows[start:after]

    def _score(self, path: str, body: Mapping[str, Any]) -> tuple[int, Mapping[str, str], Any]:
        self.scores.append(body)
        if path not in self.items:
            return 404, {}, {}
        if body["userId"] in self.strangers:
            return 400, {}, {}
        key, at = (self.items[path]["resourceId"], body["userId"]), datetime.fromisoformat(body["timestamp"])
        assert at.tzinfo is not None
        if int(at.timestamp()) <= self.seen_at.get(key, 0):
            return 409, {}, {}
        self.seen_at[key] = int(at.timestamp())
        graded = body["gradingProgress"] == "FullyGraded"
        self.marks[key] = body["scoreGiven"] / body["scoreMaximum"] * 20 if graded else None
        return 200, {}, {}
