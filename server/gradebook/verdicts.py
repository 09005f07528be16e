"""Verdicts as they are kept, read. A grading never changes, and its verdict is asked for again and again, by whoever
looks at an exercise: those that were read lately are kept, whole. What is held back from who looks is left out of them
each time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple
from uuid import UUID

from graders.core.contract.verdict import Verdict
from server.base.caches import LRUCache

KEPT_CHARACTERS = 4_000_000  # of JSON: a thousand verdicts, 40,000 each at most where one is not extraordinary


class _Read(NamedTuple):
    verdict: Verdict
    length: int


_KEPT: LRUCache[UUID, _Read] = LRUCache(KEPT_CHARACTERS, weigh=lambda read: read.length)


def read(grading_id: UUID, kept: Mapping[str, Any]) -> Verdict:
    """The verdict of a grading, from what is kept of it. Raises MalformedVerdictError."""
    known = _KEPT.get(grading_id)
    if known is None:
        known = _KEPT.put(grading_id, _Read(Verdict.from_json(kept), len(repr(kept))))
    return known.verdict
