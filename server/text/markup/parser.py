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
from server.text.markup.blocks import BlockHeader, BlockSyntaxError
from server.text.markup.nowrap import keep_punctuation_with_formulas
from server.text.markup.text import MarkdownSource, MarkupFault

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

    source: MarkdownSource
    faults: list[MarkupFault] = field(default_factory=list)

    def add_fault(self, line: int, message: str) -> None:
        """`line` counts from 0 in the text."""
        fault = MarkupFault(self.source.first_line + line, message)
        if fault not in self.faults:
            self.faults.append(fault)


def parse_blocks(job: ParseJob) -> list[Token]:
    """The tokens of the text. In their `meta`: blocks (`block`), and the line of formulas and links (`line`)."""
    text = f"{job.source.text}\n"  # the plugin of containers reads one character too many at a text's very end
    return markdown_parser().parse(text, {"job": job})


def parse_inline_text(job: ParseJob) -> list[Token]:
    """The same for a text of one paragraph."""
    return markdown_parser().parseInline(job.source.text, {"job": job})


_strict_math = math_inline_dollar(allow_space=False, allow_digits=False, allow_double=True)


def _parse_inline_formula(state: StateInline, silent: bool) -> bool:
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
def markdown_parser() -> MarkdownIt:
    options = {"html": False, "typographer": True, "quotes": ["«\u00a0", "\u00a0»", "“", "”"]}
    parser = MarkdownIt("commonmark", options).enable(["table", "strikethrough", "smartquotes"])
    parser.use(deflist_plugin).use(footnote_plugin, inline=False)
    parser.use(dollarmath_plugin, double_inline=True, allow_space=False, allow_digits=False)
    parser.inline.ruler.at("math_inline", _parse_inline_formula)
    parser.block.ruler.at("math_block", _parse_display_formula, INTERRUPTS)
    parser.use(anchors_plugin, min_level=FIRST_LEVEL, max_level=LAST_LEVEL, slug_func=slug_of_title)
    parser.use(container_plugin, "block", validate=_is_block_opening)
    parser.core.ruler.after("block", "balise_blocks", _read_blocks)
    parser.core.ruler.after("inline", "balise_leftovers", _report_leftover_marks)
    parser.core.ruler.push("balise_finish", _number_lines_and_check)
    return parser


_dollars = math_block_dollar(allow_labels=True, allow_blank_lines=False)


def _parse_display_formula(state: StateBlock, start: int, end: int, silent: bool) -> bool:
    """A displayed formula, which may follow a line of text at once. The plugin's rule does not know `silent`."""
    count, line = len(state.tokens), state.line
    is_formula = bool(_dollars(state, start, end, silent))
    if silent:
        del state.tokens[count:]
        state.line = line
    return is_formula


def slug_of_title(title: str) -> str:
    plain = unaccented(title.replace("’", "-"))
    return "s-" + re.sub(r"[^a-z0-9]+", "-", plain).strip("-")


def _is_block_opening(parameters: str, _markup: str) -> bool:
    return bool(parameters.strip())


def _read_blocks(state: StateCore) -> None:
    """Before the inlines: the first line of each block becomes its `block`, and its title a line of its own."""
    job: ParseJob = state.env["job"]
    lines = state.src.split("\n")
    around: list[BlockHeader | None] = []
    colons: list[int] = []
    tokens: list[Token] = []
    for token in state.tokens:
        tokens.append(token)
        if token.type == "container_block_open":
            parent = next((outer.label for outer in reversed(around) if outer is not None and outer.label), "")
            block = _parse_block_header(job, token, parent)
            around.append(block)
            token.meta["block"] = block
            if not _is_block_closed(token, lines) or (colons and len(token.markup) >= colons[-1]):
                job.add_fault(_line_of_token(token), LEFT_OPEN)
            colons.append(len(token.markup))
            if block is not None and not block.name:
                tokens.extend(_block_title_tokens(block, token))
        elif token.type == "container_block_close":
            token.meta["block"] = around.pop()
            colons.pop()
    _number_figure_captions(job, tokens)
    state.tokens = tokens


def _number_figure_captions(job: ParseJob, tokens: list[Token]) -> None:
    """The first paragraph of a figure's caption goes on from « Figure 3 : »."""
    for index, token in enumerate(tokens):
        block = token.meta.get("block")
        if block is None or not block.name or token.nesting != 1:
            continue
        if block.kind in blocks.EMPTY:
            if tokens[index + 1].type != "container_block_close":
                job.add_fault(
                    _line_of_token(token), f"rien ne se met dans « {block.kind} » : {blocks.EMPTY[block.kind]}"
                )
            continue
        if tokens[index + 1].type != "paragraph_open":
            job.add_fault(
                _line_of_token(token), "il manque le texte qui accompagne ce dessin : un paragraphe, sous son nom"
            )
        elif block.kind == "figure":
            tokens[index + 1].hidden = tokens[index + 3].hidden = True


def _parse_block_header(job: ParseJob, token: Token, parent: str) -> BlockHeader | None:
    line = _line_of_token(token)
    try:
        return blocks.parse_block_header(token.info, line, parent)
    except BlockSyntaxError as error:
        job.add_fault(line, str(error))
        return None


def _is_block_closed(token: Token, lines: list[str]) -> bool:
    assert token.map is not None
    end = lines[token.map[1]].strip(" \t>") if token.map[1] < len(lines) else ""
    return set(end) == {":"}


def _block_title_tokens(block: BlockHeader, opening: Token) -> Iterator[Token]:
    opened = Token("block_title_open", "p", 1, block=True, map=opening.map, meta={"block": block})
    yield opened
    yield Token("inline", "", 0, content=block.title, children=[], map=opening.map, level=opening.level + 1)
    yield Token("block_title_close", "p", -1, block=True, meta={"block": block})


def _report_leftover_marks(state: StateCore) -> None:
    """Right after the inlines, while what was escaped is still apart: marks that are left were meant for something."""
    job: ParseJob = state.env["job"]
    for token in state.tokens:
        for child, line in iter_inline_parts(token):
            if child.type == "text":
                for pattern, message in LEFTOVERS:
                    if pattern.search(child.content):
                        job.add_fault(line, message)


def iter_inline_parts(token: Token) -> Iterator[tuple[Token, int]]:
    """Each part of a paragraph, with its line from 0."""
    line = _line_of_token(token)
    for child in token.children or ():
        yield child, line
        line += child.type in {"softbreak", "hardbreak"}
        line += child.content.count("\n") if child.type.startswith("math") else 0


def _line_of_token(token: Token) -> int:
    return token.map[0] if token.map else 0


def _number_lines_and_check(state: StateCore) -> None:
    job: ParseJob = state.env["job"]
    level = FIRST_LEVEL - 1
    for token in state.tokens:
        token.meta["line"] = _line_of_token(token)
        if token.type == "heading_open":
            level = _check_heading_level(job, token, level)
        for child, line in iter_inline_parts(token):
            child.meta["line"] = line
            if child.type == "text":
                child.content = french(_replace_dashes(child.content))
            elif child.type == "image":
                job.add_fault(
                    line, "les images ne sont pas servies dans un texte : un encadré « figure » montre un dessin"
                )
        if token.children:
            token.children = keep_punctuation_with_formulas(token.children)
    _check_footnotes(job, state.env)


def _check_heading_level(job: ParseJob, token: Token, previous_level: int) -> int:
    level = int(token.tag[1])
    if level < FIRST_LEVEL:
        job.add_fault(_line_of_token(token), "titre de niveau 1 : le titre vient de l’en-tête, commencez à « ## »")
    elif level > LAST_LEVEL:
        job.add_fault(_line_of_token(token), "titre trop profond : « #### » au plus")
    elif level > previous_level + 1:
        job.add_fault(
            _line_of_token(token), f"titre de niveau {level} juste sous un titre de niveau {max(previous_level, 1)}"
        )
    return level


def _check_footnotes(job: ParseJob, env: Mapping[str, Any]) -> None:
    for label, number in env.get("footnotes", {}).get("refs", {}).items():
        if number < 0:
            place = job.source.text.find(f"[^{label[1:]}]:")
            job.add_fault(job.source.text[:place].count("\n"), f"note de bas de page jamais appelée : « {label[1:]} »")


def _replace_dashes(text: str) -> str:
    return text.replace("...", "…").replace("---", "—").replace("--", "–")
