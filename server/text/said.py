"""User-written text as HTML: paragraphs, line breaks and code, and nothing else of Markdown.

A star stays a star: it is a product more often than it is emphasis. Neither links, images, HTML nor formulas.
"""

from __future__ import annotations

from functools import lru_cache

from markdown_it import MarkdownIt

from server.text.plain import visible


@lru_cache(maxsize=1)
def _renderer() -> MarkdownIt:
    return MarkdownIt("zero", {"html": False, "breaks": True}).enable(["backticks", "fence", "newline"])


def said(text: str) -> str:
    """HTML that is safe to show, whoever has written the text; its invisible characters are spelled out."""
    return str(_renderer().render(visible(text)))
