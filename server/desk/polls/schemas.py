"""What the template of the answers to the lessons' questions receives."""

from __future__ import annotations

from dataclasses import dataclass

from markupsafe import Markup

from server.desk.schemas import ClassHead


@dataclass(frozen=True)
class OptionRow:
    """One answer: so many students gave it first; `share` is their part of those who answered, from 0 to 100."""

    words: Markup
    right: bool
    students: int
    share: int


@dataclass(frozen=True)
class PollRow:
    """A question; `answered` counts students, among whom `found` were right at first."""

    title: str
    href: str
    question: Markup
    answered: int
    found: int
    options: tuple[OptionRow, ...]


@dataclass(frozen=True)
class LessonPolls:
    """The questions of one lesson."""

    title: str
    rows: tuple[PollRow, ...]


@dataclass(frozen=True)
class PollsPage:
    """`students` counts the active ones of the class."""

    head: ClassHead
    students: int
    lessons: tuple[LessonPolls, ...]
