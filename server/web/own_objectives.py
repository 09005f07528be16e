"""A student's objectives in words, for their teacher's page and for their own: states, what is left, what is wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby

from server.board.catalogue import find_misconception
from server.board.objectives import Mastery, ObjectiveState, PractisedObjective
from server.course import Course
from server.course.kinds import SEANCE
from server.course.models import Lesson
from server.web.views import exercise_href, lesson_href
from server.web.words import count_with_noun

Link = tuple[str, str]
SIGNS = {Mastery.mastered: "✓", Mastery.started: "…", Mastery.weak: "!", Mastery.none: "·"}
WORDS = {
    Mastery.mastered: "acquis",
    Mastery.started: "en cours",
    Mastery.weak: "à retravailler",
    Mastery.none: "pas commencé",
}
SHOWN_STATES = (Mastery.mastered, Mastery.started, Mastery.weak, Mastery.none)


@dataclass(frozen=True)
class StudentObjectiveRow:
    """A student in an objective. `mistakes`: titles; `rest`: exercises to solve still; `lesson`: what to read again."""

    objective: PractisedObjective
    state: Mastery
    sign: str
    word: str
    short: str
    text: str
    since: datetime | None
    solved: tuple[Link, ...]
    rest: tuple[Link, ...]
    mistakes: tuple[str, ...]
    lesson: Link

    @property
    def next_exercise_link(self) -> Link | None:
        """The exercise with which the student goes on."""
        return self.rest[0] if self.rest else None


@dataclass(frozen=True)
class LessonObjectiveGroup:
    """The objectives of a student in one lesson, unfolded where `is_open`; `summary`: in words, beside the title."""

    title: str
    is_open: bool
    rows: tuple[StudentObjectiveRow, ...]
    summary: str = ""


def find_lesson(course: Course, module: str, slug: str) -> Lesson:
    return next(lesson for lesson in course.modules[module].lessons if lesson.slug == slug)


def lesson_title(lesson: Lesson) -> str:
    return f"{lesson.label} · {lesson.title.partition(' :')[0]}" if lesson.kind is SEANCE else lesson.title


def count_states_in_words(rows: Sequence[StudentObjectiveRow]) -> str:
    """Return how many objectives are in each state, in words: « 3 acquis, 2 pas commencés »."""
    counts = [(state, sum(row.state is state for row in rows)) for state in SHOWN_STATES]
    return ", ".join(
        count_with_noun(count, WORDS[state], WORDS[state] + ("s" if state is Mastery.none else ""))
        for state, count in counts
        if count
    )


def group_objectives_by_lesson(
    course: Course, module: str, rows: Sequence[StudentObjectiveRow]
) -> tuple[LessonObjectiveGroup, ...]:
    """Group the objectives of a student by lesson; the first lesson in which something is under way is unfolded."""
    groups: list[LessonObjectiveGroup] = []
    for slug, group in groupby(rows, key=lambda row: row.objective.objective.lesson):
        lesson, own = find_lesson(course, module, slug), tuple(group)
        is_under_way = any(row.state in {Mastery.weak, Mastery.started} for row in own)
        is_open = is_under_way and not any(earlier.is_open for earlier in groups)
        groups.append(LessonObjectiveGroup(lesson_title(lesson), is_open, own, count_states_in_words(own)))
    return tuple(groups)


def build_objective_row(course: Course, module: str, found: ObjectiveState) -> StudentObjectiveRow:
    """Lay out the state of a student in an objective."""
    objective = found.objective.objective
    stars = {exercise.id: exercise.stars for exercise in course.modules[module].exercises}
    rest = [name for name in found.objective.exercises if name not in found.solved and not stars.get(name)]
    with_mistake = [exercise for exercise, _ in found.mistakes]
    rest.sort(key=lambda name: (name not in with_mistake, name not in found.failing))
    lesson = find_lesson(course, module, objective.lesson)
    return StudentObjectiveRow(
        objective=found.objective,
        state=found.state,
        sign=SIGNS[found.state],
        word=WORDS[found.state],
        short=objective.short,
        text=objective.text,
        since=found.mastered_at if found.state is Mastery.mastered else None,
        solved=tuple(_exercise_link(course, name) for name in found.solved),
        rest=tuple(_exercise_link(course, name) for name in rest) if found.state is not Mastery.mastered else (),
        mistakes=tuple(
            find_misconception(course, exercise, mistake).diagnosis.title for exercise, mistake in found.mistakes
        ),
        lesson=(lesson.label, lesson_href(lesson)),
    )


def _exercise_link(course: Course, name: str) -> Link:
    exercise = course.exercises.get(name)
    return (name, "") if exercise is None else (exercise.title, exercise_href(exercise))
