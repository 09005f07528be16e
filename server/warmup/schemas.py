"""A question of a warm-up: its words, its options, and what is said of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class WarmUpOption:
    """An answer that one may choose; `mistake` names in French the mistake that leads to it, `why` explains it."""

    id: str
    words: str
    mistake: str = ""
    why: str = ""


@dataclass(frozen=True)
class WarmUpQuestion:
    """A question as plain French with `code` in backquotes. `needed`: students who are to see its subject again.

    `subject` is what is scheduled; `exercise` and `misconception` are stored with an answer; `why` explains the right
    option, whose id is `right`.
    """

    subject: str
    exercise: str
    misconception: str
    title: str
    href: str
    text: str
    options: tuple[WarmUpOption, ...]
    right: str
    needed: int
    why: str = ""

    def to_data(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> WarmUpQuestion:
        return cls(**{**data, "options": tuple(WarmUpOption(**option) for option in data["options"])})

    def find_option(self, option_id: str) -> WarmUpOption | None:
        return next((option for option in self.options if option.id == option_id), None)


@dataclass(frozen=True)
class OptionCount:
    """The number of students who chose an option."""

    option: WarmUpOption
    students: int


@dataclass(frozen=True)
class QuestionWithCounts:
    """A question with the answers of a class."""

    question: WarmUpQuestion
    counts: Sequence[OptionCount]

    @property
    def answer_count(self) -> int:
        return sum(count.students for count in self.counts)
