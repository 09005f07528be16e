"""Views of the course and of the reader's progress that several rooms share: modules, exercises, addresses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.course import Course, Exercise, Module
from server.course.kinds import KINDS
from server.course.models import Lesson
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.gradebook.solutions import SolutionAudience
from server.identity.models import Account
from server.submissions.service import SubmissionService
from server.web.schemas import ExerciseRow, ModuleLink, SolutionSwitchView, StudentExerciseProgress
from server.web.words import format_mark


@dataclass(frozen=True)
class Reader:
    """The reader of a page, with the course, the submissions and the transaction.

    The database is asked who it is (`who`) when this is first wanted: in the thread of the request's function.
    """

    db: Session
    course: Course
    submissions: SubmissionService
    who: Callable[[], Account | None]

    @cached_property
    def account(self) -> Account | None:
        return self.who()


def find_module(course: Course, slug: str) -> Module:
    """Raises NotFound."""
    if slug not in course.modules:
        raise NotFound("Ce module n’existe pas.")
    return course.modules[slug]


def find_exercise(course: Course, module: str, slug: str) -> Exercise:
    """Raises NotFound."""
    exercise = course.exercises.get(f"{module}/{slug}")
    if exercise is None:
        raise NotFound("Cet exercice n’existe pas.")
    return exercise


def exercise_href(exercise: Exercise) -> str:
    return f"/{exercise.module}/exercices/{exercise.slug}"


def lesson_href(lesson: Lesson) -> str:
    return f"/{lesson.module}/lire/{lesson.slug}"


def build_solution_switch_view(audience: SolutionAudience) -> SolutionSwitchView:
    to_whom = "à tous les élèves" if audience.class_id is None else f"à la classe « {audience.class_name} »"
    verb = "Refermer" if audience.is_open else "Ouvrir"
    return SolutionSwitchView(str(audience.class_id or ""), f"{verb} le corrigé {to_whom}", audience.is_open)


def build_module_link(module: Module, progress: dict[str, ExerciseProgress] | None = None) -> ModuleLink:
    done = sum((progress or {}).get(exercise.id, NOTHING_YET).succeeded for exercise in module.exercises)
    return ModuleLink(module.slug, module.label, module.title, module.summary, len(module.exercises), done)


def build_exercise_row(exercise: Exercise, progress: ExerciseProgress) -> ExerciseRow:
    own = build_student_progress(progress)
    return ExerciseRow(exercise_href(exercise), exercise.title, exercise.summary, exercise.stars, exercise.origin, own)


def build_student_progress(progress: ExerciseProgress) -> StudentExerciseProgress:
    best = "" if progress.best is None else format_mark(20 * progress.best)
    return StudentExerciseProgress(progress.attempts, best, progress.succeeded)


def exercises_in_reading_order(module: Module) -> list[Exercise]:
    """The exercises in the order in which one meets them: those of each lesson, then those that follow none."""
    places = {lesson.slug: place for place, lesson in enumerate(module.lessons)}
    return sorted(module.exercises, key=lambda exercise: places.get(exercise.seance, len(places)))


def lessons_in_reading_order(module: Module) -> tuple[Lesson, ...]:
    """The lessons in the order in which one reads them: the séances, then what the module's page lists after them."""
    return tuple(sorted(module.lessons, key=lambda lesson: KINDS.index(lesson.kind)))
