"""The course's own code to HTML with CSS classes (Pygments): the colours are the style sheet's.

Texts of strangers go to `server.text.python_colours`, which reads anything in linear time.
"""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

from pygments import highlight as draw
from pygments.filter import Filter
from pygments.formatters import HtmlFormatter
from pygments.lexer import Lexer
from pygments.lexers import get_lexer_by_name
from pygments.token import STANDARD_TYPES, Text
from pygments.util import ClassNotFound

from server.base.caches import LRUCache

FORMATTER = HtmlFormatter(nowrap=True)
#: The classes that the style sheet has a colour for. Names, operators and commas have none: a lesson would have fifteen
#: hundred elements more.
COLOURED = frozenset(
    {
        *("k", "kn", "kc", "kd", "kr", "kt", "ow"),
        *("s", "s1", "s2", "sd", "sa", "se", "si", "sx", "sr", "sb"),
        *("m", "mi", "mf", "mh", "mo", "mb", "il"),
        *("c", "c1", "cm", "ch", "cs"),
        *("nf", "nc", "fm", "nd"),
    }
)
MAX_CACHED_CHARACTERS = 2_000_000  # characters of HTML
_cache: LRUCache[tuple[str, str], str] = LRUCache(MAX_CACHED_CHARACTERS, len)


def highlight_code_block(code: str, language: str = "python") -> str:
    """A whole `<pre>` element; plain where the language is unknown or not said."""
    body = _highlighted_html(code, language)
    return f'<pre class="code" tabindex="0"><code>{body}</code></pre>\n'


def is_known_language(language: str) -> bool:
    return _find_lexer(language) is not None


def _highlighted_html(code: str, language: str) -> str:
    lexer = _find_lexer(language)
    if lexer is None:
        return html.escape(code)
    known = _cache.get((code, language))
    return known if known is not None else _cache.put((code, language), str(draw(code, lexer, FORMATTER)))


@lru_cache(maxsize=16)
def _find_lexer(language: str) -> Lexer | None:
    try:
        lexer = get_lexer_by_name(language, stripnl=False) if language else None
    except ClassNotFound:
        return None
    if lexer is not None:
        lexer.add_filter(_KeepColouredTokens())
    return lexer


class _KeepColouredTokens(Filter):
    def filter(self, lexer: Lexer | None, stream: Iterable[tuple[Any, str]]) -> Iterator[tuple[Any, str]]:
        for kind, value in stream:
            yield (kind if STANDARD_TYPES.get(kind) in COLOURED else Text), value
