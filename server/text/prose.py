"""Short pieces of the course's Markdown (a question, an option, a word of explanation) as HTML."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from server.text.markup import MarkdownSource, MarkdownText, ModuleNames


@lru_cache(maxsize=4096)
def render_author_text(text: str, names: Callable[[], ModuleNames]) -> str:
    """HTML of an author's text, whose faults were looked for at start-up."""
    return MarkdownText(MarkdownSource(text, Path("questions.toml"), names=names)).html


def render_author_line(text: str, names: Callable[[], ModuleNames]) -> str:
    """The same without the paragraph around it, where it is a single one."""
    body = render_author_text(text, names).strip()
    inside = body.removeprefix("<p>").removesuffix("</p>")
    return inside if body == f"<p>{inside}</p>" and "<p>" not in inside else body
