"""The types that the templates of a lesson receive."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

from server.board.latest_change import LatestChange
from server.board.stuck import StuckSign
from server.desk.schemas import ClassHead
from server.lesson.models import Afterwards


@dataclass(frozen=True)
class StuckRow:
    """A stuck student: `minutes` since when, the mistake of the latest attempt in words, and what that attempt changed.

    The minutes count from the latest progress at the exercise: the mistake may be more recent. Where `sign` is no
    failure, they count from the latest attempt.

    `mistake` is empty without an attempt. `attempts` counts all at this exercise; `silent_minutes`: those since the
    latest, where they are many beside failures. `helper`: who has finished and could help, once they have helped
    `helps_before`; empty where nobody should. `seen`: when the student was seen at this exercise and by whom, in words;
    `is_just_seen`: they stand below the others.
    """

    student: str
    exercise_id: str
    name: str
    exercise: str
    minutes: int
    sign: StuckSign
    failures: int
    attempts: int
    mistake: str
    silent_minutes: int
    change: LatestChange | None
    work_href: str
    helper: str
    helps_before: str
    seen: str
    is_just_seen: bool


@dataclass(frozen=True)
class MistakeRow:
    """A mistake of the lesson: `still` names those who make it, of `made` who did, the stuck first; `href`: its
    page.

    `project_href` is empty where fewer than `fewest` made it. `remedial_href` leads to the form that gives an
    exercise to those who make it still.
    """

    title: str
    exercise: str
    still: tuple[str, ...]
    made: int
    href: str
    project_href: str
    fewest: int
    remedial_href: str


@dataclass(frozen=True)
class DayExercise:
    """An exercise of the day, with the numbers of present students who have solved it, who try, and of all of them."""

    title: str
    href: str
    solved: int
    trying: int
    students: int


@dataclass(frozen=True)
class LessonParts:
    """Everything on the page that changes while the lesson goes on. `elapsed`: since it began, in words.

    `more_mistakes`: the number of those that `mistakes` leaves out. `overcome`: title and address of each mistake of
    the last minutes that nobody makes any more. Each student is among the stuck, the `finished`, the `absent` or the
    `working`.
    """

    elapsed: str
    stuck: tuple[StuckRow, ...]
    more_stuck: tuple[str, ...]
    mistakes: tuple[MistakeRow, ...]
    more_mistakes: int
    overcome: tuple[tuple[str, str], ...]
    finished: tuple[str, ...]
    absent: tuple[str, ...]
    working: tuple[str, ...]
    exercises: tuple[DayExercise, ...]
    next_words: str


@dataclass(frozen=True)
class ExerciseChoice:
    id: str
    title: str
    chosen: bool
    stars: int


@dataclass(frozen=True)
class LessonForm:
    """The form that begins or changes a lesson; `problem`: why it is refused."""

    choices: tuple[ExerciseChoice, ...]
    next_step: Afterwards
    challenge: str
    problem: str


@dataclass(frozen=True)
class LessonPage:
    """The page of a lesson that goes on. `loaded`: when, on the school's clock, in words."""

    head: ClassHead
    loaded: str
    parts: LessonParts
    form: LessonForm
    may_run: bool
    may_comment: bool
    may_assign: bool
    stream: str


@dataclass(frozen=True)
class StartPage:
    """The page of a class without a lesson that goes on: what it would begin with, and the lessons before."""

    head: ClassHead
    form: LessonForm
    may_run: bool
    has_students: bool
    past: tuple[tuple[str, datetime], ...]
