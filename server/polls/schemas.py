"""What a question of the lessons is, and how a class answered it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class Option:
    """`words` in French, with its typography."""

    id: str
    words: str
    right: bool


@dataclass(frozen=True)
class Poll:
    """A question, named within its module (`rejeux/icp`); `href` leads to it. `before`: it is asked before a replay
    plays, and its first answer alone counts."""

    name: str
    title: str
    href: str
    question: str
    options: tuple[Option, ...]
    before: bool

    @property
    def right(self) -> str:
        """The right answer, as answers are kept."""
        return ",".join(option.id for option in self.options if option.right)


class Said(NamedTuple):
    """So many students of a class answered `first` to a poll, and `last` in the end."""

    poll: str
    first: str
    last: str
    students: int
