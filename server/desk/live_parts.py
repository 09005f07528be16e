"""Streams of the parts of a page, as HTML, to the script that puts them in place (`lesson.js`)."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Callable, Mapping
from typing import TypeVar

from server.base import root_path
from server.submissions.job_events import format_sse

SIGN_OF_LIFE = ":\n\n"
ENDED = "ended"

ShownType = TypeVar("ShownType")


async def stream_parts(
    readings: AsyncIterator[ShownType | None], render: Callable[[ShownType], Mapping[str, str] | None]
) -> AsyncIterator[str]:
    """Send the parts that have changed since they were sent; the end once `render` returns None."""
    sent: Mapping[str, str] = {}
    async for shown in readings:
        if shown is None:
            yield SIGN_OF_LIFE
            continue
        parts = render(shown)
        if parts is None:
            yield format_sse(ENDED, "")
            return
        changed = {name: root_path.with_external_paths(html) for name, html in parts.items() if sent.get(name) != html}
        sent = parts
        yield format_sse("parts", json.dumps(changed)) if changed else SIGN_OF_LIFE
