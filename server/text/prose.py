"""Short pieces of the course's Markdown (a question, an option, a word of explanation) as HTML."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from server.text.markup import Names, Source, Text


@lru_cache(maxsize=4096)
def author_html(text: str, names: Callable[[], Names]) -> str:
    """HTML of an author's text, whose faults were looked for at start-up."""
    return Text(Source(text, Path("questions.toml"), names=names)).html


def author_line_html(text: str, names: Callable[[], Names]) -> str:
    """The same without the paragraph around it, where it is a single one."""
    body = author_html(text, names).strip()
    inside = body.removeprefix("<p>").removesuffix("</p>")
    return inside if body == f"<p>{inside}</p>" and "<p>" not in inside else body
