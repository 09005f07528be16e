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
from server.text.highlight import highlight
from server.text.markup import blocks
from server.text.markup.blocks import Block
from server.text.markup.outline import CELL, Reference, Title, missing_reference_message
from server.text.markup.parser import ParseJob, markdown, parse, parse_inline
from server.text.markup.text import Fault, LabelTarget, Link, Names, Source, UnresolvedLink, still_of

CONTENTS_EXCLUDED = {"link_open", "link_close", "footnote_ref"}
QED = '<p class="qed">∎</p>\n'
Rule = Callable[["HtmlWriter", Sequence[Token], int], str]


@dataclass(frozen=True)
class RenderedHtml:
    """HTML; what is at fault stands there as plain text."""

    html: str
    faults: tuple[Fault, ...]


def render(source: Source, *, inline: bool = False) -> RenderedHtml:
    """HTML of `source`, or with `inline` of its one paragraph without `<p>`. Faults are told, never raised."""
    job = ParseJob(source)
    tokens = parse_inline(job) if inline else parse(job)
    katex.render_ahead(_formulas(tokens))
    written = HtmlWriter(job, source.names()).write(tokens)
    return RenderedHtml(written, tuple(sorted(job.faults, key=lambda fault: fault.line)))


def _formulas(tokens: Sequence[Token]) -> Iterator[katex.Formula]:
    for token in tokens:
        for part in (token, *(token.children or ())):
            if part.type.startswith("math"):
                yield part.content.strip(), part.type != "math_inline"


def render_title(source: Source, title: Title) -> str:
    """A heading for a table of contents: without the links and the calls of notes that it may hold."""
    children = [child for child in title.inline.children or () if child.type not in CONTENTS_EXCLUDED]
    return HtmlWriter(ParseJob(source), source.names()).write_inline(children)


@dataclass
class HtmlWriter:
    """One rendering: markdown-it's own renderer, except where RULES say otherwise."""

    job: ParseJob
    names: Names
    figures: int = 0

    @cached_property
    def _renderer(self) -> Any:
        renderer: Any = copy(markdown().renderer)
        renderer.rules = {**renderer.rules, **{name: self._bound(rule) for name, rule in RULES.items()}}
        return renderer

    def _bound(self, rule: Rule) -> Callable[..., str]:
        return lambda tokens, index, _options, _env: rule(self, tokens, index)

    def write(self, tokens: Sequence[Token]) -> str:
        return str(self._renderer.render(tokens, markdown().options, {}))

    def write_inline(self, tokens: Sequence[Token]) -> str:
        return str(self._renderer.renderInline(tokens, markdown().options, {}))

    @property
    def page(self) -> str:
        return self.job.source.page

    def exists(self, what: str, target: str, token: Token, *, empty: bool = False) -> bool:
        """False, and told, where the text speaks of what does not exist."""
        message = missing_reference_message(Reference(what, target, 0, empty), self.names, self.page)
        if message:
            self.job.fault(token.meta["line"], message)
        return not message

    def formula(self, token: Token, *, display: bool) -> str:
        tex = token.content
        try:
            return katex.render_formula(tex.strip(), display=display)
        except katex.TexError as error:
            inside = tex.lstrip("\n")[: error.position or 0].count("\n") + (display and tex.startswith("\n"))
            self.job.fault(token.meta["line"] + inside, f"formule refusée : {error}")
            return f'<code class="fault">{html.escape(tex.strip())}</code>'


def _math(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return writer.formula(tokens[index], display=False)


def _math_inside(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return writer.formula(tokens[index], display=True)


def _math_display(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return f'<div class="math-display" tabindex="0">{writer.formula(tokens[index], display=True)}</div>\n'


def _equation(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    label = html.escape(tokens[index].info)
    target = writer.names.labels.get(tokens[index].info)
    number = f'<span class="equation-number">{target.name}</span>' if target else ""
    drawn = writer.formula(tokens[index], display=True)
    return f'<div class="math-display equation" id="{label}" tabindex="0">{drawn}{number}</div>\n'


def _table_open(_writer: HtmlWriter, _tokens: Sequence[Token], _index: int) -> str:
    return '<div class="table-scroll" tabindex="0"><table>\n'


def _table_close(_writer: HtmlWriter, _tokens: Sequence[Token], _index: int) -> str:
    return "</table></div>\n"


def _link_open(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    token = tokens[index]
    target = str(token.attrGet("href") or "")
    empty = index + 1 < len(tokens) and tokens[index + 1].type == "link_close"
    if not writer.exists("link", target, token, empty=empty):
        return f'<a class="fault">{html.escape(target) if empty else ""}'
    link = writer.names.link(target, writer.page)
    return f"<a{_attributes(link)}>{html.escape(link.text) if empty else ''}"


def _attributes(link: Link) -> str:
    extra = ""
    if link.term:
        extra = f' class="term" data-term="{html.escape(link.term)}"'
    elif link.external:
        extra = ' class="external" rel="noopener noreferrer"'
    return f'{extra} href="{html.escape(link.href)}"'


def _code(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    language, *words = tokens[index].info.split() or [""]
    drawn = highlight(tokens[index].content, language)
    if words[:1] == [CELL] and len(words) == 2:
        return _cell(html.escape(words[1]), f"/{writer.names.module}/cellules", drawn)
    return f'<div class="code-block">{drawn}</div>\n'


def _cell(name: str, action: str, code: str) -> str:
    opening = f'<section class="cell" id="cellule-{name}" data-name="{name}" data-action="{action}">'
    return f'{opening}<div class="cell-code">{code}</div></section>\n'


def _block_open(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    block: Block | None = tokens[index].meta["block"]
    if block is None:
        return "<div>\n"
    if block.kind in MEDIA:
        return MEDIA[block.kind](writer, block, tokens[index])
    if block.path:
        known = writer.exists("chemin", block.path, tokens[index])
        marked = f' data-later="{block.path}"' if known else ""
        return f'<details class="block block-later"{marked} open>'
    if block.folded:
        state = " open" if block.kind == "preuve" else ""
        return f'<details class="block block-{block.kind}"{state}>'
    anchor = f' id="{block.label}"' if block.label else ""
    return f'<{blocks.KINDS[block.kind].element} class="block block-{block.kind}"{anchor}>'


def _block_close(_writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    block: Block | None = tokens[index].meta["block"]
    if block is None:
        return "</div>\n"
    if block.kind in blocks.EMPTY:
        return "</section>\n"
    if block.name:
        return "</figcaption></figure>\n"
    if block.folded:
        return f"{QED if block.kind == 'preuve' else ''}</details>\n"
    return f"</{blocks.KINDS[block.kind].element}>\n"


def _title_open(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    token = tokens[index]
    block: Block = token.meta["block"]
    if block.folded:
        heading = _folded_heading(writer, block, token)
        return f"<summary>{heading}" + (" — " if heading and block.title else "")
    kind = blocks.KINDS[block.kind]
    target = writer.names.labels.get(block.label)
    number = f"\u00a0{target.number}" if target and target.number else ""
    return f'<p class="block-title"><span class="block-label">{kind.title}{number}</span> '


def _folded_heading(writer: HtmlWriter, block: Block, token: Token) -> str:
    """« Démonstration du théorème 1 »; no need to say it inside the exercise itself."""
    heading = blocks.FOLDED[block.kind]
    if not block.label or block.label == block.parent or not writer.exists("bloc", block.label, token):
        return heading
    kind, name = _reference_name(writer.names.labels[block.label])
    return f"{heading} {kind.of}{name}"


def _reference_name(target: LabelTarget) -> tuple[blocks.BlockKind, str]:
    """« théorème 1 », « équation (3) », or « exemple » where there is no number."""
    if target.kind == "equation":
        return blocks.EQUATION, f"{blocks.EQUATION.noun}\u00a0{target.name}"
    kind = blocks.KINDS[target.kind]
    return kind, target.name or kind.noun


def _title_close(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    block: Block = tokens[index].meta["block"]
    if block.path:
        reader = html.escape(french(writer.names.paths.get(block.path, "")))
        return f' <span class="later-note">«\u00a0{reader}\u00a0»\u00a0: pour plus tard</span></summary>\n'
    return f"</summary>\n{_back_link(writer, block)}" if block.folded else "</p>\n"


def _back_link(writer: HtmlWriter, block: Block) -> str:
    """A link to what is proved or answered: below the summary, which is a button and cannot hold it."""
    target = writer.names.labels.get(block.label)
    if target is None or block.label == block.parent:
        return ""
    try:
        link = writer.names.link(f"#{block.label}", writer.page)
    except UnresolvedLink:
        return ""
    return f'<p class="block-back"><a href="{html.escape(link.href)}">{_reference_name(target)[1]}</a></p>\n'


def _header_open(_writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    """An empty corner of a table is no header."""
    if not tokens[index + 1].children:
        return "<td>"
    style = tokens[index].attrGet("style")
    return f'<th style="{html.escape(str(style))}">' if style else "<th>"


def _header_close(writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    return "</th>\n" if tokens[index - 1].children else "</td>\n"


def _figure_open(writer: HtmlWriter, block: Block, token: Token) -> str:
    if not writer.exists("figure", block.name, token):
        return f'<figure class="drawing"><code class="fault">{block.name}</code><figcaption>'
    writer.figures += 1
    label = f'<span class="figure-number">Figure\u00a0{writer.figures}\u00a0:</span> '
    return f'<figure class="drawing" id="fig-{block.name}">{_images(writer, block.name)}<figcaption>{label}'


def _images(writer: HtmlWriter, name: str) -> str:
    """A drawing in both themes."""
    picture = writer.names.pictures[name]
    alt = html.escape(french(picture.alt))
    source = f"/{writer.names.module}/figures/{name}.svg?theme="
    return "".join(
        f'<img class="figure-{theme}" src="{source}{theme}" alt="{alt}" loading="lazy" '
        f'width="{picture.width}" height="{picture.height}">'
        for theme in ("light", "dark")
    )


def _replay_open(writer: HtmlWriter, block: Block, token: Token) -> str:
    if not writer.exists("rejeu", block.name, token):
        return f'<figure class="replay"><code class="fault">{block.name}</code><figcaption>'
    source = f"/{writer.names.module}/rejeux/{block.name}"
    opening = f'<figure class="replay" id="rejeu-{block.name}" data-source="{source}">'
    return f'{opening}<div class="replay-stage"></div><figcaption>'


def _question_open(writer: HtmlWriter, block: Block, token: Token) -> str:
    """Where a question stands: who serves the lesson writes it there, since it is an exercise's."""
    if not writer.exists("question", block.name, token):
        return f'<section><code class="fault">{block.name}</code>'
    return f'<section class="asked" id="question-{block.name.replace("/", "-")}" data-question="{block.name}">'


def _exercise_open(writer: HtmlWriter, block: Block, token: Token) -> str:
    """Where an exercise is first possible: who serves the lesson writes its card there."""
    if not writer.exists("faire", block.name, token):
        return f'<section><code class="fault">{block.name}</code>'
    return f'<section class="to-do" id="faire-{block.name}" data-exercise="{block.name}">'


def _retrieval_open(writer: HtmlWriter, block: Block, token: Token) -> str:
    """Where a retrieval question stands: who serves the lesson draws its numbers."""
    name = f"{writer.page}/{block.name}"
    if not writer.exists("redire", name, token):
        return f'<section><code class="fault">{block.name}</code>'
    return f'<section class="asked recalled" id="redire-{block.name}" data-retrieval="{name}">'


def _manipulation_open(writer: HtmlWriter, block: Block, token: Token) -> str:
    """What the hand moves, and a drawing for who has no script."""
    if not writer.exists("manipulation", block.name, token):
        return f'<figure class="replay"><code class="fault">{block.name}</code><figcaption>'
    source = f"/{writer.names.module}/manipulations/{block.name}"
    still = f'<div class="without-script">{_images(writer, still_of(block.name))}</div>'
    opening = f'<figure class="replay manipulation" id="manipulation-{block.name}" data-hands="{source}">'
    return f'{opening}{still}<div class="replay-stage"></div><figcaption>'


#: What opens each of the blocks that have a name.
MEDIA: dict[str, Callable[[HtmlWriter, Block, Token], str]] = {
    "figure": _figure_open,
    "rejeu": _replay_open,
    "manipulation": _manipulation_open,
    "question": _question_open,
    "faire": _exercise_open,
    "redire": _retrieval_open,
}


def _footnote_anchor(_writer: HtmlWriter, tokens: Sequence[Token], index: int) -> str:
    meta = tokens[index].meta
    which = f"{meta['id'] + 1}:{meta['subId']}" if meta.get("subId", 0) else f"{meta['id'] + 1}"
    return f' <a href="#fnref{which}" class="footnote-backref" aria-label="Retour au texte">↩\ufe0e</a>'


RULES: dict[str, Rule] = {
    "math_inline": _math,
    "math_inline_double": _math_inside,
    "math_block": _math_display,
    "math_block_label": _equation,
    "table_open": _table_open,
    "table_close": _table_close,
    "th_open": _header_open,
    "th_close": _header_close,
    "link_open": _link_open,
    "fence": _code,
    "code_block": _code,
    "container_block_open": _block_open,
    "container_block_close": _block_close,
    "block_title_open": _title_open,
    "block_title_close": _title_close,
    "footnote_anchor": _footnote_anchor,
}
