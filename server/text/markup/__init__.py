"""The course's Markdown: blocks with numbers, references that are followed, mathematics, and nothing that could run."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from threading import RLock
from typing import TYPE_CHECKING

from server.text.markup.outline import CodeCell, Section, TextOutline, complete_empty_links
from server.text.markup.text import (
    LabelTarget,
    LinkableLesson,
    MarkdownSource,
    MarkupFault,
    ModuleNames,
    PictureSize,
    still_drawing_name,
)

if TYPE_CHECKING:
    from server.text.markup.render import RenderedHtml

__all__ = [
    "CodeCell",
    "Heading",
    "LabelTarget",
    "LinkableLesson",
    "MarkdownSource",
    "MarkdownText",
    "MarkupFault",
    "ModuleNames",
    "PictureSize",
    "Section",
    "TextOutline",
]  # fmt: skip

log = logging.getLogger(__name__)

#: A class that opens one lesson together has it rendered once (formulas are drawn by one thread anyway).
_RENDERING = RLock()


@dataclass(frozen=True)
class Heading:
    """A heading of a lesson (`level` 2 to 4), for its table of contents. `html` may hold formulas."""

    level: int
    id: str
    html: str
    text: str


@dataclass(frozen=True, eq=False)
class MarkdownText:
    """A text: read at the first need, and rendered (formulas are slow to draw) when somebody looks at it.

    With `inline` it is one paragraph, to stand inside another.
    """

    source: MarkdownSource
    inline: bool = False

    @cached_property
    def outline(self) -> TextOutline:
        from server.text.markup.reader import (
            read_outline,  # what reads Markdown is loaded for the first text that is read
        )

        return read_outline(self.source)

    @cached_property
    def rendered(self) -> RenderedHtml:
        from server.text.markup.render import render_markdown

        with _RENDERING:
            return self.__dict__.get("rendered") or render_markdown(self.source, inline=self.inline)

    @property
    def is_rendered(self) -> bool:
        return "rendered" in self.__dict__

    @cached_property
    def html(self) -> str:
        for fault in self.rendered.faults:
            log.warning("%s:%s: %s", self.source.path, fault.line, fault.message)
        return self.rendered.html

    @cached_property
    def sections(self) -> tuple[Section, ...]:
        """Plain text by heading; needs no formula to be drawn."""
        return tuple(
            Section(section.id, self._fill_empty_links(section.title), self._fill_empty_links(section.text))
            for section in self.outline.sections
        )

    @cached_property
    def headings(self) -> tuple[Heading, ...]:
        from server.text.markup.render import render_title

        return tuple(
            Heading(title.level, title.id, render_title(self.source, title), self._fill_empty_links(title.text))
            for title in self.outline.titles
        )

    @property
    def figures(self) -> tuple[str, ...]:
        return tuple(self.outline.figures)

    @property
    def replays(self) -> tuple[str, ...]:
        return tuple(self.outline.replays)

    @property
    def questions(self) -> tuple[str, ...]:
        """The questions of exercises that it asks, `exercise/question`."""
        return tuple(self.outline.questions)

    @property
    def exercises(self) -> tuple[str, ...]:
        """The exercises that are to be done in it, by their slugs."""
        return tuple(self.outline.exercises)

    @property
    def retrieval_questions(self) -> tuple[str, ...]:
        """The retrieval questions that it asks, without its own name."""
        return tuple(self.outline.retrievals)

    @property
    def content_amounts(self) -> Mapping[tuple[str, str], int]:
        """Amounts of words and of things to look at, run or answer, as in its outline."""
        return self.outline.amounts

    @property
    def still_drawings(self) -> tuple[str, ...]:
        """The drawings that stand for its manipulations where there is no script."""
        return tuple(still_drawing_name(name) for name in self.outline.manipulations)

    @property
    def code_cells(self) -> tuple[CodeCell, ...]:
        return tuple(self.outline.cells)

    def _fill_empty_links(self, text: str) -> str:
        return complete_empty_links(text, self.source.names(), self.source.page)

    def find_faults(self, *, formulas: bool) -> tuple[MarkupFault, ...]:
        """What is wrong with it, in the order of the lines; bad TeX only shows when formulas are drawn."""
        unresolved = self.outline.find_unresolved_references(self.source.names(), self.source.page)
        faults = {*self.outline.faults, *unresolved, *(self.rendered.faults if formulas else ())}
        return tuple(sorted(faults, key=lambda fault: (fault.line, fault.message)))
