"""Reads a text for its outline: what it holds, before anything is known of the others."""

from __future__ import annotations

import re
from collections.abc import Sequence

from markdown_it.token import Token

from graders.core.syntax_trees import parse_source
from server.text.highlight import is_known_language
from server.text.markup import blocks
from server.text.markup.outline import (
    CELL,
    HEAD,
    LEFT,
    RIGHT,
    CodeCell,
    HeadingTitle,
    LabelledBlock,
    Reference,
    Section,
    TextOutline,
)
from server.text.markup.parser import ParseJob, iter_inline_parts, parse_blocks
from server.text.markup.tex import tex_as_plain_text
from server.text.markup.text import SLUG, MarkdownSource

#: How blocks with a name are counted; an exercise is counted by itself.
AMOUNTS = {
    "figure": "figures", "rejeu": "replays", "manipulation": "manipulations", "question": "questions",
    "redire": "questions",
}  # fmt: skip


def read_outline(source: MarkdownSource) -> TextOutline:
    """Read a lesson, or a statement (then nothing may have a label)."""
    job = ParseJob(source)
    reader = _OutlineReader(job)
    reader.read_tokens(parse_blocks(job))
    reader.found.faults = sorted(job.faults, key=lambda fault: fault.line)
    return reader.found


class _OutlineReader:
    def __init__(self, job: ParseJob) -> None:
        self._job = job
        self.found = TextOutline()
        self._heading = ("", "")
        self._text: list[str] = []
        #: The path that leaves each of the open blocks for later.
        self._paths = [""]

    def read_tokens(self, tokens: Sequence[Token]) -> None:
        for index, token in enumerate(tokens):
            if token.type == "heading_open":
                self._close_section()
                self._read_heading(token, tokens[index + 1])
            elif token.type == "inline":
                self._read_inline(token, is_title=tokens[index - 1].type == "heading_open")
            elif token.type == "container_block_open":
                block = token.meta["block"]
                self._paths.append((block.path if block is not None else "") or self._paths[-1])
                self._read_block(token)
            elif token.type == "container_block_close":
                self._paths.pop()
            elif token.type.startswith("math_block"):
                self._read_equation(token)
            elif token.type in {"fence", "code_block"}:
                self._read_code_block(token)
        self._close_section()

    def _read_heading(self, token: Token, inline: Token) -> None:
        title = HeadingTitle(int(token.tag[1]), str(token.attrGet("id") or ""), paragraph_as_plain_text(inline), inline)
        self._heading = (title.id, title.text)
        if title.id:  # other levels are faults
            self._add_anchor(title.id, token)
            self.found.titles.append(title)

    def _close_section(self) -> None:
        text = re.sub(r"\s+", " ", " ".join(self._text)).strip()
        if text or self._heading[0]:
            self.found.sections.append(Section(*self._heading, text))
        self._text = []

    def _add_anchor(self, anchor: str, token: Token) -> None:
        if anchor in self.found.anchors:
            self._add_fault(token, f"« #{anchor} » figure deux fois dans la page")
        self.found.anchors.add(anchor)

    def _add_fault(self, token: Token, message: str) -> None:
        self._job.add_fault(token.meta["line"], message)

    def _add_reference(self, kind: str, target: str, token: Token, *, empty: bool = False) -> None:
        line = self._job.source.first_line + token.meta["line"]
        self.found.references.append(Reference(kind, target, line, empty))

    def _require_lesson_page(self, token: Token, what: str) -> bool:
        if not self._job.source.page:
            self._add_fault(token, f"{what} n’a sa place que dans une page à lire")
        return bool(self._job.source.page)

    def _read_inline(self, token: Token, *, is_title: bool) -> None:
        parts = token.children or []
        for index, child in enumerate(parts):
            if child.type == "link_open":
                empty = parts[index + 1].type == "link_close"
                self._add_reference("link", str(child.attrGet("href") or ""), child, empty=empty)
        if not is_title:
            self._text.append(paragraph_as_plain_text(token))
        self._add_to_amount("words", len(paragraph_as_plain_text(token).split()))

    def _add_to_amount(self, unit: str, amount: int = 1) -> None:
        self.found.amounts[self._paths[-1], unit] += amount

    def _read_block(self, token: Token) -> None:
        block = token.meta["block"]
        if block is None:
            return
        if block.name:
            self._read_medium(token, block.kind, block.name)
        elif block.path and self._require_lesson_page(token, "une partie à laisser pour plus tard"):
            self._add_reference("chemin", block.path, token)
        elif block.label and block.is_folded:
            self._add_reference("bloc", block.label, token)
        elif block.label and self._require_lesson_page(token, "une étiquette"):
            self._add_label(token, block.label, block.kind)
            self._text.append(f"{LEFT}{HEAD}#{block.label}{RIGHT}")  # « théorème 1 » can be looked for

    def _read_medium(self, token: Token, kind: str, name: str) -> None:
        what, prefix, found = {
            "figure": ("une figure", "fig", self.found.figures),
            "rejeu": ("un rejeu", "rejeu", self.found.replays),
            "manipulation": ("une manipulation", "manipulation", self.found.manipulations),
            "question": ("une question", "question", self.found.questions),
            "faire": ("un exercice à faire", "faire", self.found.exercises),
            "redire": ("une question à redire", "redire", self.found.retrievals),
        }[kind]
        if not self._require_lesson_page(token, what):
            return
        self._add_to_amount(AMOUNTS.get(kind, kind))
        self._add_anchor(f"{prefix}-{name.replace('/', '-')}", token)
        found.append(name)
        self._add_reference(kind, f"{self._job.source.page}/{name}" if kind == "redire" else name, token)

    def _add_label(self, token: Token, label: str, kind: str) -> None:
        self._add_anchor(label, token)
        self.found.labels.append(LabelledBlock(label, kind, self._job.source.first_line + token.meta["line"]))

    def _read_equation(self, token: Token) -> None:
        self._add_to_amount("formulas")
        self._text.append(tex_as_plain_text(token.content))
        if token.type == "math_block_label" and self._require_lesson_page(token, "une étiquette"):
            try:
                blocks.require_valid_label(token.info)
            except blocks.BlockSyntaxError as error:
                self._add_fault(token, str(error))
            else:
                self._add_label(token, token.info, "equation")

    def _read_code_block(self, token: Token) -> None:
        self._text.append(token.content)
        language, *words = token.info.split()[:4] or [""]
        if language and not is_known_language(language):
            self._add_fault(token, f"langage inconnu : « {language} »")
        if not words:
            self._add_to_amount("words", len(token.content.split()))
            return
        if language != "python" or words[0] != CELL or len(words) != 2:
            self._add_fault(token, "après le langage, rien, ou « python cellule nom-de-cellule »")
        elif not re.fullmatch(SLUG, words[1]):
            self._add_fault(
                token, f"nom de cellule mal formé : « {words[1]} » (minuscules sans accent, chiffres, tirets)"
            )
        elif self._require_lesson_page(token, "une cellule"):
            self._read_code_cell(token, words[1])

    def _read_code_cell(self, token: Token, name: str) -> None:
        self._add_to_amount("cells")
        self._add_anchor(f"cellule-{name}", token)
        line = self._job.source.first_line + token.meta["line"] + 1
        self.found.cells.append(CodeCell(name, token.content, line))
        try:
            parse_source(token.content)
        except (SyntaxError, ValueError) as error:
            inside = (error.lineno or 1) if isinstance(error, SyntaxError) else 1
            self._job.add_fault(token.meta["line"] + inside, f"cette cellule ne se compile pas ({error})")


def paragraph_as_plain_text(token: Token) -> str:
    """A paragraph as plain text; links left empty are kept apart for `completed`."""
    parts = []
    inside = token.children or []
    for index, (child, _) in enumerate(iter_inline_parts(token)):
        if child.type in {"text", "code_inline"}:
            parts.append(child.content)
        elif child.type.startswith("math"):
            parts.append(tex_as_plain_text(child.content))
        elif child.type in {"softbreak", "hardbreak"}:
            parts.append(" ")
        elif child.type == "link_open" and inside[index + 1].type == "link_close":
            parts.append(f"{LEFT}{child.attrGet('href')}{RIGHT}")
    return "".join(parts)
