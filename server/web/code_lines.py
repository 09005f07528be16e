"""Code by its lines, with the conversations that stand below them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from server.comments.schemas import Conversation
from server.identity.models import Account
from server.text.plain import show_invisible_characters
from server.text.python_colours import colour_python_lines
from server.web.threads import ThreadView, build_thread_views

MOST_NUMBERED = 1500


@dataclass(frozen=True)
class CodeLineView:
    """A line of code in HTML, and the threads that stand below it."""

    number: int
    html: Markup
    threads: tuple[ThreadView, ...] = ()


@dataclass(frozen=True)
class CodeView:
    """Code by its lines; `rest` is what comes after those that are numbered."""

    lines: tuple[CodeLineView, ...]
    rest: str


def build_code_view(code: str, conversations: Sequence[Conversation], account: Account | None) -> CodeView:
    below: dict[int, list[Conversation]] = {}
    for talk in conversations:
        if talk.lines is not None:
            below.setdefault(talk.lines.last, []).append(talk)
    *numbered, rest = show_invisible_characters(code).removesuffix("\n").split("\n", MOST_NUMBERED)
    if len(numbered) < MOST_NUMBERED:
        numbered, rest = [*numbered, rest], ""
    lines = tuple(
        CodeLineView(number, Markup(line), build_thread_views(below[number], account) if number in below else ())
        for number, line in enumerate(colour_python_lines("\n".join([*numbered, ""])), 1)
    )
    return CodeView(lines, rest)
