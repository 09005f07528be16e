"""Markdown of the course to HTML: French typography, mathematics, boxes, highlighted code; no raw HTML."""

from __future__ import annotations

import html
import re
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.renderer import RendererHTML
from markdown_it.rules_core import StateCore
from markdown_it.token import Token
from mdit_py_plugins.anchors import anchors_plugin
from mdit_py_plugins.container import container_plugin
from mdit_py_plugins.deflist import deflist_plugin
from mdit_py_plugins.dollarmath import dollarmath_plugin
from mdit_py_plugins.footnote import footnote_plugin
from mdit_py_plugins.front_matter import front_matter_plugin

from server.catalogue import katex
from server.catalogue.highlight import highlight
from server.catalogue.typography import french

BOXES = {
    "rappel": "Rappel",
    "definition": "Définition",
    "theoreme": "Théorème",
    "methode": "Méthode",
    "exemple": "Exemple",
    "attention": "Attention",
    "note": "Note",
}


@dataclass(frozen=True)
class Source:
    """Markdown text and where it comes from; `first_line` is the line of its first character in that file."""

    text: str
    path: Path
    first_line: int = 1


class MarkupError(Exception):
    """The text cannot be rendered as its author meant. `line` is a line of the file."""

    def __init__(self, path: Path, line: int, message: str) -> None:
        super().__init__(f"{path}:{line}: {message}")
        self.path, self.line, self.message = path, line, message


class _Fault(Exception):
    """Inside a rendering: a fault at a line counted from 0 in the text."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line, self.message = line, message


def render(source: Source) -> str:
    """HTML of `source`. Raises MarkupError on bad TeX, an unknown box, an image, a heading of level 1."""
    try:
        return str(_parser().render(source.text))
    except _Fault as fault:
        raise MarkupError(source.path, source.first_line + fault.line, fault.message) from fault


@lru_cache(maxsize=1)
def _parser() -> MarkdownIt:
    options = {"html": False, "typographer": True, "quotes": ["«\u00a0", "\u00a0»", "“", "”"], "highlight": highlight}
    parser = MarkdownIt("commonmark", options).enable(["table", "strikethrough", "replacements", "smartquotes"])
    parser.use(front_matter_plugin).use(deflist_plugin).use(footnote_plugin)
    parser.use(dollarmath_plugin, double_inline=True, allow_space=False, allow_digits=False)
    parser.use(anchors_plugin, min_level=2, max_level=4, slug_func=_slug)
    parser.use(container_plugin, "box", validate=_is_box, render=_render_box)
    parser.core.ruler.push("balise", _finish)
    for name, rule in RULES.items():
        parser.add_render_rule(name, rule)
    return parser


def _slug(title: str) -> str:
    plain = unicodedata.normalize("NFKD", title.replace("’", "-")).encode("ascii", "ignore").decode().lower()
    return "s-" + re.sub(r"[^a-z0-9]+", "-", plain).strip("-")


def _is_box(parameters: str, _markup: str) -> bool:
    return bool(parameters.strip())


def _render_box(_renderer: RendererHTML, tokens: Sequence[Token], index: int, _options: Any, _env: Any) -> str:
    token = tokens[index]
    if token.nesting != 1:
        return "</aside>\n"
    kind, _, title = token.info.strip().partition(" ")
    label = BOXES[kind] + (french(f" : {title.strip()}") if title.strip() else "")
    return f'<aside class="box box-{kind}"><p class="box-title">{html.escape(label)}</p>\n'


def _finish(state: StateCore) -> None:
    """After parsing: draw the formulas, set the typography, refuse what would not come out as meant."""
    for token in state.tokens:
        line = token.map[0] if token.map else 0
        _refuse(token, line)
        if token.type.startswith("math_block"):
            token.meta["html"] = _formula(token.content, line, display=True)
        for child, child_line in _children(token, line):
            _finish_inline(child, child_line)


def _refuse(token: Token, line: int) -> None:
    if token.type == "heading_open" and token.tag == "h1":
        raise _Fault(line, "titre de niveau 1 : le titre vient de exercise.toml, commencez à « ## »")
    if token.type == "container_box_open" and token.info.strip().split(" ")[0] not in BOXES:
        raise _Fault(line, f"encadré inconnu : « {token.info.strip()} » (connus : {', '.join(BOXES)})")


def _children(token: Token, line: int) -> Iterator[tuple[Token, int]]:
    for child in token.children or ():
        yield child, line
        line += child.type in {"softbreak", "hardbreak"}
        line += child.content.count("\n") if child.type.startswith("math") else 0


def _finish_inline(token: Token, line: int) -> None:
    if token.type == "text":
        token.content = french(token.content)
    elif token.type.startswith("math_inline"):
        token.meta["html"] = _formula(token.content, line, display=token.type == "math_inline_double")
    elif token.type == "image":
        raise _Fault(line, "les images ne sont pas servies dans un énoncé")


def _formula(tex: str, line: int, *, display: bool) -> str:
    try:
        return katex.render(tex.strip(), display=display)
    except katex.TexError as error:
        inside = tex.lstrip("\n")[: error.position or 0].count("\n") + (display and tex.startswith("\n"))
        raise _Fault(line + inside, f"formule refusée : {error}") from error


def _math(_: RendererHTML, tokens: Sequence[Token], index: int, _options: Any, _env: Any) -> str:
    return str(tokens[index].meta["html"])


def _math_display(_: RendererHTML, tokens: Sequence[Token], index: int, _options: Any, _env: Any) -> str:
    return f'<div class="math-display" tabindex="0">{tokens[index].meta["html"]}</div>\n'


def _table_open(_: RendererHTML, _tokens: Sequence[Token], _index: int, _options: Any, _env: Any) -> str:
    return '<div class="table-scroll" tabindex="0"><table>\n'


def _table_close(_: RendererHTML, _tokens: Sequence[Token], _index: int, _options: Any, _env: Any) -> str:
    return "</table></div>\n"


RULES = {
    "math_inline": _math,
    "math_inline_double": _math,
    "math_block": _math_display,
    "math_block_label": _math_display,
    "table_open": _table_open,
    "table_close": _table_close,
}
