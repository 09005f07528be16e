"""Colour the Python of students in linear time, whatever it holds.

Pygments reads some texts in quadratic time and worse, in the process that serves everybody; its lexers stay for the
course's own texts. Here one expression splits the text: its repetitions are possessive, so each character is read a
bounded number of times, and what is no Python is left plain.
"""

from __future__ import annotations

import html
import keyword
import re
from collections.abc import Iterator, Sequence
from itertools import islice

from server.base.caches import LRUCache

_WORDS = {
    **dict.fromkeys(keyword.kwlist, "k"),
    **dict.fromkeys(("False", "None", "True"), "kc"),
    **dict.fromkeys(("from", "import"), "kn"),
    **dict.fromkeys(("and", "in", "is", "not", "or"), "ow"),
}
_DEFINED = {"def": "nf", "class": "nc"}
#: Classes of the pieces of a text, besides those of words.
COMMENT, STRINGS = "c1", frozenset({"sa", "s1", "s2", "sd"})
#: Tokens that are coloured, those of a thousand lines: a file of 64 KB may have sixty thousand, and stays plain after.
MOST_TOKENS = 8000
MAX_CACHED_CHARACTERS = 2_000_000  # characters of HTML
_cache: LRUCache[str, tuple[str, ...]] = LRUCache(
    MAX_CACHED_CHARACTERS, lambda lines: sum(map(len, lines)) + 50 * len(lines)
)
_TOKEN = re.compile(
    r"""
      (?P<c1>\#[^\n]*+)
    | (?P<prefix>[rRbBuUfF]{0,2}+)(?P<string>
          (?P<triple>'{3}(?:[^'\\]|\\.|'(?!''))*+(?:'{3}|\Z)?+ | "{3}(?:[^"\\]|\\.|"(?!""))*+(?:"{3}|\Z)?+)
        | '(?:[^'\\\n]|\\.)*+'?+
        | "(?:[^"\\\n]|\\.)*+"?+
      )
    | (?P<mh>0[xX][0-9a-fA-F_]++) | (?P<mo>0[oO][0-7_]++) | (?P<mb>0[bB][01_]++)
    | (?P<mf>\d[\d_]*+\.[\d_]*+(?:[eE][+-]?\d[\d_]*+)?+[jJ]?+ | \.\d[\d_]*+(?:[eE][+-]?\d[\d_]*+)?+[jJ]?+
        | \d[\d_]*+[eE][+-]?\d[\d_]*+[jJ]?+ | \d[\d_]*+[jJ])
    | (?P<mi>\d[\d_]*+)
    | (?P<decorator>@[^\W\d][\w.]*+)
    | (?P<word>[^\W\d]\w*+)
    | (?P<blank>\s++)
    | (?P<other>[^\w\s\#'"@.]++ | .)
    """,
    re.VERBOSE | re.DOTALL,
)


def colour_python_lines(code: str) -> Sequence[str]:
    r"""Return the HTML of each line of Python whose line ends are `\n`: no element goes from one line to the next.

    What was coloured lately is remembered: who has the page of a long file made again and again keeps nobody waiting.
    """
    known = _cache.get(code)
    return known if known is not None else _cache.put(code, colour_python_lines_uncached(code.removesuffix("\n")))


def colour_python_lines_uncached(code: str) -> tuple[str, ...]:
    """Colour lines as `colour_python_lines` does, and remember nothing. The last line of `code` has no end."""
    parts, end = list[str](), 0
    for style, text in islice(split_into_coloured_tokens(code), MOST_TOKENS):
        end += len(text)
        escaped = html.escape(text)
        if not style:
            parts.append(escaped)
            continue
        pieces = (f'<span class="{style}">{piece}</span>' if piece else "" for piece in escaped.split("\n"))
        parts.append("\n".join(pieces))
    parts.append(html.escape(code[end:]))
    return tuple("".join(parts).split("\n"))


def colour_python_block(code: str) -> str:
    """Return a whole `<pre>` element, as `server.text.highlight` does."""
    body = "\n".join(colour_python_lines(code))
    return f'<pre class="code" tabindex="0"><code>{body}\n</code></pre>\n'


def split_into_coloured_tokens(code: str) -> Iterator[tuple[str, str]]:
    """Yield the text in pieces, each with the class of its colour, or none."""
    begins_line, defined = True, ""
    for token in _TOKEN.finditer(code):
        kind, text = token.lastgroup or "", token[0]
        if token["string"]:
            if token["prefix"]:
                yield "sa", token["prefix"]
            plain = "s2" if token["string"].startswith('"') else "s1"
            yield "sd" if token["triple"] and begins_line else plain, token["string"]
        elif kind == "word":
            yield defined or _WORDS.get(text, ""), text
        elif kind == "decorator":
            yield "nd" if begins_line else "", text
        else:
            yield kind if kind not in {"blank", "other"} else "", text
        defined = _DEFINED.get(text, defined if kind == "blank" and defined else "")
        begins_line = "\n" in text or begins_line if kind == "blank" else False
