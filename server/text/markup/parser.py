"""Markdown to tokens: which rules apply, what blocks are, French typography, and what is refused at once."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from markdown_it import MarkdownIt
from markdown_it.ruler import RuleOptionsType
from markdown_it.rules_block import StateBlock
from markdown_it.rules_core import StateCore
from markdown_it.rules_inline import StateInline
from markdown_it.token import Token
from mdit_py_plugins.anchors import anchors_plugin
from mdit_py_plugins.container import container_plugin
from mdit_py_plugins.deflist import deflist_plugin
from mdit_py_plugins.dollarmath import dollarmath_plugin
from mdit_py_plugins.dollarmath.index import math_block_dollar, math_inline_dollar
from mdit_py_plugins.footnote import footnote_plugin

from graders.typography import french, unaccented
from server.text.markup import blocks
from server.text.markup.blocks import BadBlock, Block
from server.text.markup.nowrap import join_punctuation
from server.text.markup.text import Fault, Source

INTERRUPTS: RuleOptionsType = {"alt": ["paragraph", "reference", "blockquote", "list"]}
FIRST_LEVEL, LAST_LEVEL = 2, 4
LEFT_OPEN = "encadré non refermé (celui qui en contient d’autres s’ouvre par plus de « : » qu’eux)"
LEFTOVERS = (
    (re.compile(r"\$"), "formule mal fermée : un « $ » seul, collé à un chiffre ou à une espace (le signe : \\$)"),
    (re.compile(r"\]\("), "lien mal écrit : [texte](adresse), sans espace dans l’adresse"),
    (re.compile(r"\[\^"), "note de bas de page sans texte"),
    (re.compile(r"</?[a-zA-Z][^>]*>|<!--"), "pas de HTML dans un texte"),
    (re.compile(r"^:::"), "« ::: » sans encadré ouvert, ou sans ligne à lui"),
    (re.compile(r"\*\*|`"), "gras ou code mal refermé : « ** » ou « ` » seul"),
)


@dataclass
class ParseJob:
    """One text on its way; `faults` gathers what is wrong with it."""

    source: Source
    faults: list[Fault] = field(default_factory=list)

    def fault(self, line: int, message: str) -> None:
        """`line` counts from 0 in the text."""
        fault = Fault(self.source.first_line + line, message)
        if fault not in self.faults:
            self.faults.append(fault)


def parse(job: ParseJob) -> list[Token]:
    """The tokens of the text. In their `meta`: blocks (`block`), and the line of formulas and links (`line`)."""
    text = f"{job.source.text}\n"  # the plugin of containers reads one character too many at a text's very end
    return markdown().parse(text, {"job": job})


def parse_inline(job: ParseJob) -> list[Token]:
    """The same for a text of one paragraph."""
    return markdown().parseInline(job.source.text, {"job": job})


_strict_math = math_inline_dollar(allow_space=False, allow_digits=False, allow_double=True)


def _math_inline(state: StateInline, silent: bool) -> bool:
    """The plugin's rule, which takes the last character of a text for the one before its first."""
    if state.pos:
        return _strict_math(state, silent)
    text = state.src
    state.src = f"{text} "
    try:
        return _strict_math(state, silent)
    finally:
        state.src = text


@lru_cache(maxsize=1)
def markdown() -> MarkdownIt:
    options = {"html": False, "typographer": True, "quotes": ["«\u00a0", "\u00a0»", "“", "”"]}
    parser = MarkdownIt("commonmark", options).enable(["table", "strikethrough", "smartquotes"])
    parser.use(deflist_plugin).use(footnote_plugin, inline=False)
    parser.use(dollarmath_plugin, double_inline=True, allow_space=False, allow_digits=False)
    parser.inline.ruler.at("math_inline", _math_inline)
    parser.block.ruler.at("math_block", _math_block, INTERRUPTS)
    parser.use(anchors_plugin, min_level=FIRST_LEVEL, max_level=LAST_LEVEL, slug_func=slug)
    parser.use(container_plugin, "block", validate=_opens)
    parser.core.ruler.after("block", "balise_blocks", _read_blocks)
    parser.core.ruler.after("inline", "balise_leftovers", _refuse_leftovers)
    parser.core.ruler.push("balise_finish", _finish)
    return parser


_dollars = math_block_dollar(allow_labels=True, allow_blank_lines=False)


def _math_block(state: StateBlock, start: int, end: int, silent: bool) -> bool:
    """A displayed formula, which may follow a line of text at once. The plugin's rule does not know `silent`."""
    count, line = len(state.tokens), state.line
    is_formula = bool(_dollars(state, start, end, silent))
    if silent:
        del state.tokens[count:]
        state.line = line
    return is_formula


def slug(title: str) -> str:
    plain = unaccented(title.replace("’", "-"))
    return "s-" + re.sub(r"[^a-z0-9]+", "-", plain).strip("-")


def _opens(parameters: str, _markup: str) -> bool:
    return bool(parameters.strip())


def _read_blocks(state: StateCore) -> None:
    """Before the inlines: the first line of each block becomes its `block`, and its title a line of its own."""
    job: ParseJob = state.env["job"]
    lines = state.src.split("\n")
    around: list[Block | None] = []
    colons: list[int] = []
    tokens: list[Token] = []
    for token in state.tokens:
        tokens.append(token)
        if token.type == "container_block_open":
            parent = next((outer.label for outer in reversed(around) if outer is not None and outer.label), "")
            block = _block(job, token, parent)
            around.append(block)
            token.meta["block"] = block
            if not _is_closed(token, lines) or (colons and len(token.markup) >= colons[-1]):
                job.fault(_line(token), LEFT_OPEN)
            colons.append(len(token.markup))
            if block is not None and not block.name:
                tokens.extend(_title(block, token))
        elif token.type == "container_block_close":
            token.meta["block"] = around.pop()
            colons.pop()
    _join_captions(job, tokens)
    state.tokens = tokens


def _join_captions(job: ParseJob, tokens: list[Token]) -> None:
    """The first paragraph of a figure's caption goes on from « Figure 3 : »."""
    for index, token in enumerate(tokens):
        block = token.meta.get("block")
        if block is None or not block.name or token.nesting != 1:
            continue
        if block.kind in blocks.EMPTY:
            if tokens[index + 1].type != "container_block_close":
                job.fault(_line(token), f"rien ne se met dans « {block.kind} » : {blocks.EMPTY[block.kind]}")
            continue
        if tokens[index + 1].type != "paragraph_open":
            job.fault(_line(token), "il manque le texte qui accompagne ce dessin : un paragraphe, sous son nom")
        elif block.kind == "figure":
            tokens[index + 1].hidden = tokens[index + 3].hidden = True


def _block(job: ParseJob, token: Token, parent: str) -> Block | None:
    line = _line(token)
    try:
        return blocks.parse_block_header(token.info, line, parent)
    except BadBlock as error:
        job.fault(line, str(error))
        return None


def _is_closed(token: Token, lines: list[str]) -> bool:
    assert token.map is not None
    end = lines[token.map[1]].strip(" \t>") if token.map[1] < len(lines) else ""
    return set(end) == {":"}


def _title(block: Block, opening: Token) -> Iterator[Token]:
    opened = Token("block_title_open", "p", 1, block=True, map=opening.map, meta={"block": block})
    yield opened
    yield Token("inline", "", 0, content=block.title, children=[], map=opening.map, level=opening.level + 1)
    yield Token("block_title_close", "p", -1, block=True, meta={"block": block})


def _refuse_leftovers(state: StateCore) -> None:
    """Right after the inlines, while what was escaped is still apart: marks that are left were meant for something."""
    job: ParseJob = state.env["job"]
    for token in state.tokens:
        for child, line in iter_inline_parts(token):
            if child.type == "text":
                for pattern, message in LEFTOVERS:
                    if pattern.search(child.content):
                        job.fault(line, message)


def iter_inline_parts(token: Token) -> Iterator[tuple[Token, int]]:
    """Each part of a paragraph, with its line from 0."""
    line = _line(token)
    for child in token.children or ():
        yield child, line
        line += child.type in {"softbreak", "hardbreak"}
        line += child.content.count("\n") if child.type.startswith("math") else 0


def _line(token: Token) -> int:
    return token.map[0] if token.map else 0


def _finish(state: StateCore) -> None:
    job: ParseJob = state.env["job"]
    level = FIRST_LEVEL - 1
    for token in state.tokens:
        token.meta["line"] = _line(token)
        if token.type == "heading_open":
            level = _check_heading(job, token, level)
        for child, line in iter_inline_parts(token):
            child.meta["line"] = line
            if child.type == "text":
                child.content = french(_dashes(child.content))
            elif child.type == "image":
                job.fault(line, "les images ne sont pas servies dans un texte : un encadré « figure » montre un dessin")
        if token.children:
            token.children = join_punctuation(token.children)
    _check_footnotes(job, state.env)


def _check_heading(job: ParseJob, token: Token, before: int) -> int:
    level = int(token.tag[1])
    if level < FIRST_LEVEL:
        job.fault(_line(token), "titre de niveau 1 : le titre vient de l’en-tête, commencez à « ## »")
    elif level > LAST_LEVEL:
        job.fault(_line(token), "titre trop profond : « #### » au plus")
    elif level > before + 1:
        job.fault(_line(token), f"titre de niveau {level} juste sous un titre de niveau {max(before, 1)}")
    return level


def _check_footnotes(job: ParseJob, env: Mapping[str, Any]) -> None:
    for label, number in env.get("footnotes", {}).get("refs", {}).items():
        if number < 0:
            place = job.source.text.find(f"[^{label[1:]}]:")
            job.fault(job.source.text[:place].count("\n"), f"note de bas de page jamais appelée : « {label[1:]} »")


def _dashes(text: str) -> str:
    return text.replace("...", "…").replace("---", "—").replace("--", "–")
