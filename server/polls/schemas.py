"""What a question of the lessons is, and how a class answered it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from markupsafe import Markup


@dataclass(frozen=True)
class Option:
    """`words` in French, with its typography, as HTML that stands in a line."""

    id: str
    words: Markup
    right: bool


@dataclass(frozen=True)
class Poll:
    """A question, named within its module (`rejeux/icp`, `verification/amcl`); `href` leads to it.

    `before`: it is asked before a replay plays, and its first answer alone counts; else it is marked in place, as often
    as one likes. `several`: right answers may be several.
    """

    name: str
    title: str
    href: str
    question: Markup
    options: tuple[Option, ...]
    before: bool
    several: bool = False

    @property
    def right(self) -> str:
        """The right answer, as answers are kept."""
        return ",".join(sorted(option.id for option in self.options if option.right))


@dataclass(frozen=True)
class Marked:
    """What becomes of an answer: what was said `first`, or nothing where nothing is kept; of a question that is marked
    in place, whether this one is right, and why, as HTML."""

    first: str
    right: bool | None = None
    why: str = ""


class Said(NamedTuple):
    """So many students of a class answered `first` to a poll, and `last` in the end."""

    poll: str
    first: str
    last: str
    students: int
