"""User-written text as HTML: paragraphs, line breaks and code, and nothing else of Markdown.

A star stays a star: it is a product more often than it is emphasis. Neither links, images, HTML nor formulas.
"""

from __future__ import annotations

from functools import lru_cache

from markdown_it import MarkdownIt

from server.base.caches import LRUCache
from server.text.plain import show_invisible_characters


@lru_cache(maxsize=1)
def _message_renderer() -> MarkdownIt:
    return MarkdownIt("zero", {"html": False, "breaks": True}).enable(["backticks", "fence", "newline"])


MAX_CACHED_CHARACTERS = 2_000_000  # characters of HTML
_cache: LRUCache[str, str] = LRUCache(MAX_CACHED_CHARACTERS, len)


def cached_message_html(text: str) -> str:
    """HTML that is safe to show, whoever has written the text; its invisible characters are spelled out.

    What was rendered lately is remembered: a page shows a hundred messages, of which the worst take 14 ms each.
    """
    known = _cache.get(text)
    return known if known is not None else _cache.put(text, render_message_html(text))


def render_message_html(text: str) -> str:
    """Render a message as `cached_message_html` does, and remember nothing."""
    return str(_message_renderer().render(show_invisible_characters(text)))
