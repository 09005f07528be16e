"""What the templates receive of one student's work, of the questions of a class, of words to several students."""

from __future__ import annotations

from dataclasses import dataclass

from server.comments.side_by_side import SideBySide
from server.desk.schemas import ClassHead
from server.web.threads import Draft, ThreadView, WriterView


@dataclass(frozen=True)
class StudentHead:
    """Whose work it is; `gone` says since when nothing more of it is read, or is empty."""

    name: str
    href: str
    groups: tuple[str, ...]
    gone: str


@dataclass(frozen=True)
class StandingRow:
    """Where a student stands in one exercise: a sign and a word; `points` out of 20 or empty."""

    title: str
    href: str
    tone: str
    sign: str
    word: str
    points: str
    attempts: int
    when: str
    when_text: str
    mistake: str
    asking: int


@dataclass(frozen=True)
class StudentPage:
    head: ClassHead
    student: StudentHead
    rows: tuple[StandingRow, ...]
    solved: int
    asking: int


@dataclass(frozen=True)
class AttemptListRow:
    """An attempt: `href` leads to it, `compared_href` to what it changed; `here`: that is what is shown."""

    number: int
    href: str
    compared_href: str
    here: bool
    points: str
    outcome: str
    mistake: str
    when: str
    when_text: str


@dataclass(frozen=True)
class CodeChange:
    """What an attempt changed since the one before."""

    number: int
    beside: SideBySide
    earlier: str
    later: str


@dataclass(frozen=True)
class WorkPage:
    """A student's attempts at an exercise. `change` is None for a first attempt, and where there is no code.

    `newer` and `older` are the addresses of the pages of the list beside it, or empty.
    """

    head: ClassHead
    student: StudentHead
    exercise_title: str
    exercise_href: str
    action: str
    attempts: tuple[AttemptListRow, ...]
    total: int
    newer: str
    older: str
    change: CodeChange | None
    threads: tuple[ThreadView, ...]
    writer: WriterView
    draft: Draft
    word_href: str


@dataclass(frozen=True)
class QuestionRow:
    """A thread of the class: whose work, of what, how it began."""

    href: str
    student: str
    student_href: str
    exercise: str
    about: str
    state: str
    label: str
    text: str
    messages: int
    when: str
    when_text: str


@dataclass(frozen=True)
class FilterView:
    label: str
    href: str
    here: bool


@dataclass(frozen=True)
class QuestionsPage:
    head: ClassHead
    filters: tuple[FilterView, ...]
    rows: tuple[QuestionRow, ...]
    newer: str
    older: str


@dataclass(frozen=True)
class SentNoteRow:
    """A word that was said: to how many, and how many say that they have read it."""

    exercise: str
    mistake: str
    author: str
    text: str
    link: str
    link_title: str
    readers: int
    seen: int
    when: str
    when_text: str


@dataclass(frozen=True)
class NoteForm:
    """A word to say: in which exercise, for which mistake (none: for all), to whom, where it may send them.

    `links` are groups of addresses with their titles.
    """

    exercise: str
    exercise_title: str
    mistake: str
    mistake_title: str
    students: tuple[str, ...]
    links: tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
    link: str
    draft: Draft


@dataclass(frozen=True)
class NotesPage:
    """`mistakes` are those of the chosen exercise now: address, title, how many have it, and whether it is chosen."""

    head: ClassHead
    exercises: tuple[tuple[str, str], ...]
    exercise: str
    mistakes: tuple[tuple[str, str, int, bool], ...]
    form: NoteForm | None
    told: tuple[SentNoteRow, ...]
