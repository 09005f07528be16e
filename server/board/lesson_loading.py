"""Load the state of a lesson, and propose its exercises, in the caller's transaction."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from server.board.latest_change import LatestChange, find_change_between
from server.board.lesson_state import LessonState, build_lesson_state
from server.board.progress import ClassProgress
from server.course import Course
from server.lesson import repository
from server.lesson.models import LiveLesson
from server.lesson.service import MAX_EXERCISES

MAX_COMPARED = 12


def propose_lesson_exercises(progress: ClassProgress, available: Sequence[str]) -> tuple[str, ...]:
    """Return the exercises to begin a lesson with: the first ones that most of those to whom
    they are given have not solved yet."""
    wanted = [
        name
        for name in available
        if 2 * _count_students_who_solved(progress, name) < max(1, _count_students_concerned(progress, name))
    ]
    return tuple((wanted or list(available))[:MAX_EXERCISES])


def _count_students_concerned(progress: ClassProgress, exercise: str) -> int:
    return sum(progress.is_assigned_to_student(student, exercise) for student in progress.students)


def _count_students_who_solved(progress: ClassProgress, exercise: str) -> int:
    standings = (progress.totals_by_pair.get((student.id, exercise)) for student in progress.students)
    return sum(totals is not None and totals.first_success_at is not None for totals in standings)


def load_lesson_state(db: Session, progress: ClassProgress, lesson: LiveLesson) -> LessonState:
    return build_lesson_state(progress, lesson, repository.load_visits(db, lesson.id))


def load_latest_changes(
    db: Session, progress: ClassProgress, pairs: Collection[tuple[UUID, str]]
) -> Mapping[tuple[UUID, str], LatestChange | None]:
    """Return what the latest attempt of each pair changed; pairs with fewer than two attempts are left out."""
    own = {pair: progress.attempts[pair] for pair in list(pairs)[:MAX_COMPARED] if pair in progress.attempts}
    last = {pair: (attempts[-2].id, attempts[-1].id) for pair, attempts in own.items() if len(attempts) > 1}
    sources = repository.load_submission_sources(db, [identity for ids in last.values() for identity in ids])
    return {
        pair: find_change_between(sources[before], sources[after], is_code=_is_code_exercise(progress.course, pair[1]))
        for pair, (before, after) in last.items()
        if before in sources and after in sources
    }


def _is_code_exercise(course: Course, exercise: str) -> bool:
    served = course.exercises.get(exercise)
    return served is not None and served.kind == "code"
