"""Tokens to HTML, once everything that a text speaks of is known."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from markdown_it.token import Token

from graders.typography import french
from server.text import katex
from server.text.highlight import highlight_code_block
from server.text.markup import blocks
from server.text.markup.blocks import BlockHeader
from server.text.markup.outline import CELL, HeadingTitle, Reference, missing_reference_message
from server.text.markup.parser import ParseJob, markdown_parser, parse_blocks, parse_inline_text
from server.text.markup.text import (
    MarkdownSource,
    MarkupFault,
    ModuleNames,
    ResolvedLink,
    UnresolvedLink,
    still_drawing_name,
)

CONTENTS_EXCLUDED = {"link_open", "link_close", "footnote_ref"}
QED = '<p class="qed">∎</p>\n'
Rule = Callable[["HtmlWriter", Sequence[Token], int], str]


@dataclass(frozen=True)
class RenderedHtml:
    """HTML; what is at fault stands there as plain text."""

    html: str
    faults: tuple[MarkupFault, ...]


def render_markdown(source: MarkdownSource, *, inline: bool = False) -> RenderedHtml:
    """HTML of `source`, or with `inline` of its one paragraph without `<p>`. Faults are told, never raised."""
    job = ParseJob(source)
    tokens = parse_inline_text(job) if inline else parse_blocks(job)
    katex.render_formulas_ahead(_find_formulas(tokens))
    written = HtmlWriter(job, source.names()).write(tokens)
    return RenderedHtml(written, tuple(sorted(job.faults, key=lambda fault: fault.line)))


def _find_formulas(tokens: Sequence[Token]) -> Iterator[katex.Formula]:
    for token in tokens:
        for part in (token, *(token.children or ())):
            if part.type.startswith("math"):
                yield part.content.strip(), part.type != "math_inline"


def render_title(source: MarkdownSource, title: HeadingTitle) -> str:
    """A heading for a table of contents: without the links and the calls of notes that it may hold."""
    children = [child for child in title.inline.children or () if child.type not in CONTENTS_EXCLUDED]
    return HtmlWriter(ParseJob(source), source.names()).write_inline(children)


@dataclass
class HtmlWriter:
    """One rendering: markdown-it's own renderer, except where RULES say otherwise."""

    job: ParseJob
    names: ModuleNames
    figures: int = 0

    @cached_property
    def _markdown_it_renderer(self) -> Any:
        renderer: Any = copy(markdown_parser().renderer)
        renderer.rules = {**renderer.rules, **{name: self._bind_rule(rule) for name, rule in RULES.items()}}
        return renderer

    def _bind_rule(self, rule: Rule) -> Callable[..., str]:
        return lambda tokens, index, _options, _env: rule(self, tokens, index)

    def write(self, tokens: Sequence[Token]) -> str:
        return str(self._markdown_it_renderer.render(tokens, markdown_parser().options, {}))

    def write_inline(self, tokens: Sequence[Token]) -> str:
        return str(self._markdown_it_renderer.renderInline(tokens, markdown_parser().options, {}))

    @property
    def current_page_slug(self) -> str:
        return self.job.source.page

    def does_target_exist(self, kind: str, target: str, token: Token, *, empty: bool = False) -> bool:
        """False, and told, where the text speaks of what does not exist."""
        message = missing_reference_message(Reference(kind, target, 0, empty), self.names, self.current_page_slug)
        if message:
            self.job.add_fault(token.meta["line"], message)
        return not message

    def render_formula(self, token: Token, *, display: bool) -> str:
        tex = token.content
        try:
            return katex.render_formula(tex.strip(), display=display)
        except katex.TexError as error:
            inside = tex.lstrip("\n")[: error.position or 0].count("\n") + (display and tex.startswith("\n"))
            self.job.add_fault(token.meta["line"] + inside, f"formule refusée : {error}")
            return f'<code class="fault">{html.escape(tex.strip())}</code>'


def _render_inline_formula(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return writer.render_formula(tokens[index], display=False)


def _render_formula_in_line(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return writer.render_formula(tokens[index], display=True)


def _render_display_formula(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return f'<div class="math-display" tabindex="0">{writer.render_formula(tokens[index], display=True)}</div>\n'


def _render_numbered_equation(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    label = html.escape(tokens[index].info)
    target = writer.names.labels.get(tokens[index].info)
    number = f'<span class="equation-number">{target.display_name}</span>' if target else ""
    drawn = writer.render_formula(tokens[index], display=True)
    return f'<div class="math-display equation" id="{label}" tabindex="0">{drawn}{number}</div>\n'


def _render_table_open(_writer: HtmlWriter, _tokens: Sequence[Token], _index: int) -> str:
    return '<div class="table-scroll" tabindex="0"><table>\n'


def _render_table_close(_writer: HtmlWriter, _tokens: Sequence[Token], _index: int) -> str:
    return "</table></div>\n"


def _render_link_open(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    token = tokens[index]
    target = str(token.attrGet("href") or "")
    empty = index + 1 < len(tokens) and tokens[index + 1].type == "link_close"
    if not writer.does_target_exist("link", target, token, empty=empty):
        return f'<a class="fault">{html.escape(target) if empty else ""}'
    link = writer.names.resolve_link(target, writer.current_page_slug)
    return f"<a{_link_attributes(link)}>{html.escape(link.text) if empty else ''}"


def _link_attributes(link: ResolvedLink) -> str:
    extra = ""
    if link.term:
        extra = f' class="term" data-term="{html.escape(link.term)}"'
    elif link.external:
        extra = ' class="external" rel="noopener noreferrer"'
    return f'{extra} href="{html.escape(link.href)}"'


def _render_code_block(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    language, *words = tokens[index].info.split() or [""]
    drawn = highlight_code_block(tokens[index].content, language)
    if words[:1] == [CELL] and len(words) == 2:
        return _render_code_cell(html.escape(words[1]), f"/{writer.names.module}/cellules", drawn)
    return f'<div class="code-block">{drawn}</div>\n'


def _render_code_cell(name: str, action: str, code: str) -> str:
    opening = f'<section class="cell" id="cellule-{name}" data-name="{name}" data-action="{action}">'
    return f'{opening}<div class="cell-code">{code}</div></section>\n'


def _render_block_open(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    block: BlockHeader | None = tokens[index].meta["block"]
    if block is None:
        return "<div>\n"
    if block.kind in MEDIA:
        return MEDIA[block.kind](writer, block, tokens[index])
    if block.path:
        known = writer.does_target_exist("chemin", block.path, tokens[index])
        marked = f' data-later="{block.path}"' if known else ""
        return f'<details class="block block-later"{marked} open>'
    if block.is_folded:
        state = " open" if block.kind == "preuve" else ""
        return f'<details class="block block-{block.kind}"{state}>'
    anchor = f' id="{block.label}"' if block.label else ""
    return f'<{blocks.KINDS[block.kind].element} class="block block-{block.kind}"{anchor}>'


def _render_block_close(_writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    block: BlockHeader | None = tokens[index].meta["block"]
    if block is None:
        return "</div>\n"
    if block.kind in blocks.EMPTY:
        return "</section>\n"
    if block.name:
        return "</figcaption></figure>\n"
    if block.is_folded:
        return f"{QED if block.kind == 'preuve' else ''}</details>\n"
    return f"</{blocks.KINDS[block.kind].element}>\n"


def _render_block_title_open(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    token = tokens[index]
    block: BlockHeader = token.meta["block"]
    if block.is_folded:
        heading = _folded_block_heading(writer, block, token)
        return f"<summary>{heading}" + (" — " if heading and block.title else "")
    kind = blocks.KINDS[block.kind]
    target = writer.names.labels.get(block.label)
    number = f"\u00a0{target.number}" if target and target.number else ""
    return f'<p class="block-title"><span class="block-label">{kind.title}{number}</span> '


def _folded_block_heading(writer: HtmlWriter, block: BlockHeader, token: Token) -> str:
    """« Démonstration du théorème 1 »; no need to say it inside the exercise itself."""
    heading = blocks.FOLDED[block.kind]
    if not block.label or block.label == block.parent or not writer.does_target_exist("bloc", block.label, token):
        return heading
    target = writer.names.labels[block.label]
    kind, name = blocks.block_kind_and_name(target.kind, target.display_name)
    return f"{heading} {kind.of}{name}"


def _render_block_title_close(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    block: BlockHeader = tokens[index].meta["block"]
    if block.path:
        reader = html.escape(french(writer.names.paths.get(block.path, "")))
        return f' <span class="later-note">«\u00a0{reader}\u00a0»\u00a0: pour plus tard</span></summary>\n'
    return f"</summary>\n{_render_back_link(writer, block)}" if block.is_folded else "</p>\n"


def _render_back_link(writer: HtmlWriter, block: BlockHeader) -> str:
    """A link to what is proved or answered: below the summary, which is a button and cannot hold it."""
    target = writer.names.labels.get(block.label)
    if target is None or block.label == block.parent:
        return ""
    try:
        link = writer.names.resolve_link(f"#{block.label}", writer.current_page_slug)
    except UnresolvedLink:
        return ""
    _, name = blocks.block_kind_and_name(target.kind, target.display_name)
    return f'<p class="block-back"><a href="{html.escape(link.href)}">{name}</a></p>\n'


def _render_table_header_open(_writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    """An empty corner of a table is no header."""
    if not tokens[index + 1].children:
        return "<td>"
    style = tokens[index].attrGet("style")
    return f'<th style="{html.escape(str(style))}">' if style else "<th>"


def _render_table_header_close(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return "</th>\n" if tokens[index - 1].children else "</td>\n"


def _render_figure_open(writer: HtmlWriter, block: BlockHeader, token: Token) -> str:
    if not writer.does_target_exist("figure", block.name, token):
        return f'<figure class="drawing"><code class="fault">{block.name}</code><figcaption>'
    writer.figures += 1
    label = f'<span class="figure-number">Figure\u00a0{writer.figures}\u00a0:</span> '
    return (
        f'<figure class="drawing" id="fig-{block.name}">{_render_themed_images(writer, block.name)}<figcaption>{label}'
    )


def _render_themed_images(writer: HtmlWriter, name: str) -> str:
    """A drawing in both themes."""
    picture = writer.names.pictures[name]
    alt = html.escape(french(picture.alt))
    source = f"/{writer.names.module}/figures/{name}.svg?theme="
    return "".join(
        f'<img class="figure-{theme}" src="{source}{theme}" alt="{alt}" loading="lazy" '
        f'width="{picture.width}" height="{picture.height}">'
        for theme in ("light", "dark")
    )


def _render_replay_open(writer: HtmlWriter, block: BlockHeader, token: Token) -> str:
    if not writer.does_target_exist("rejeu", block.name, token):
        return f'<figure class="replay"><code class="fault">{block.name}</code><figcaption>'
    source = f"/{writer.names.module}/rejeux/{block.name}"
    opening = f'<figure class="replay" id="rejeu-{block.name}" data-source="{source}">'
    return f'{opening}<div class="replay-stage"></div><figcaption>'


def _render_question_placeholder(writer: HtmlWriter, block: BlockHeader, token: Token) -> str:
    """Where a question stands: who serves the lesson writes it there, since it is an exercise's."""
    if not writer.does_target_exist("question", block.name, token):
        return f'<section><code class="fault">{block.name}</code>'
    return f'<section class="asked" id="question-{block.name.replace("/", "-")}" data-question="{block.name}">'


def _render_exercise_placeholder(writer: HtmlWriter, block: BlockHeader, token: Token) -> str:
    """Where an exercise is first possible: who serves the lesson writes its card there."""
    if not writer.does_target_exist("faire", block.name, token):
        return f'<section><code class="fault">{block.name}</code>'
    return f'<section class="to-do" id="faire-{block.name}" data-exercise="{block.name}">'


def _render_retrieval_placeholder(writer: HtmlWriter, block: BlockHeader, token: Token) -> str:
    """Where a retrieval question stands: who serves the lesson draws its numbers."""
    name = f"{writer.current_page_slug}/{block.name}"
    if not writer.does_target_exist("redire", name, token):
        return f'<section><code class="fault">{block.name}</code>'
    return f'<section class="asked recalled" id="redire-{block.name}" data-retrieval="{name}">'


def _render_manipulation(writer: HtmlWriter, block: BlockHeader, token: Token) -> str:
    """What the hand moves, and a drawing for who has no script."""
    if not writer.does_target_exist("manipulation", block.name, token):
        return f'<figure class="replay"><code class="fault">{block.name}</code><figcaption>'
    source = f"/{writer.names.module}/manipulations/{block.name}"
    still = f'<div class="without-script">{_render_themed_images(writer, still_drawing_name(block.name))}</div>'
    opening = f'<figure class="replay manipulation" id="manipulation-{block.name}" data-hands="{source}">'
    return f'{opening}{still}<div class="replay-stage"></div><figcaption>'


#: What opens each of the blocks that have a name.
MEDIA: dict[str, Callable[[HtmlWriter, BlockHeader, Token], str]] = {
    "figure": _render_figure_open,
    "rejeu": _render_replay_open,
    "manipulation": _render_manipulation,
    "question": _render_question_placeholder,
    "faire": _render_exercise_placeholder,
    "redire": _render_retrieval_placeholder,
}


def _render_footnote_anchor(_writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    meta = tokens[index].meta
    which = f"{meta['id'] + 1}:{meta['subId']}" if meta.get("subId", 0) else f"{meta['id'] + 1}"
    return f' <a href="#fnref{which}" class="footnote-backref" aria-label="Retour au texte">↩\ufe0e</a>'


RULES: dict[str, Rule] = {
    "math_inline": _render_inline_formula,
    "math_inline_double": _render_formula_in_line,
    "math_block": _render_display_formula,
    "math_block_label": _render_numbered_equation,
    "table_open": _render_table_open,
    "table_close": _render_table_close,
    "th_open": _render_table_header_open,
    "th_close": _render_table_header_close,
    "link_open": _render_link_open,
    "fence": _render_code_block,
    "code_block": _render_code_block,
    "container_block_open": _render_block_open,
    "container_block_close": _render_block_close,
    "block_title_open": _render_block_title_open,
    "block_title_close": _render_block_title_close,
    "footnote_anchor": _render_footnote_anchor,
}
