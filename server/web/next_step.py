"""The exercise with which a reader goes on in a module, and why: pure. All pages take it from here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from server.course import Exercise, Module
from server.course.models import ReadingPath
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.recall import paths
from server.web.views import exercise_href, exercises_in_reading_order

#: Exercises that a reader has tried in vain come before those not tried yet.
AGAIN = "vous l’aviez commencé"
ON_PATH = "c’est la suite de votre chemin, {title}"
NEXT_IN_LESSON = "il suit dans {lesson}"
FIRST_LEFT = "le premier que vous n’avez pas fait"


@dataclass(frozen=True)
class NextExercise:
    """The exercise to do next; `reason` is a clause that says why, `is_begun`: tried in vain before."""

    exercise: Exercise
    reason: str
    is_begun: bool

    @property
    def href(self) -> str:
        return exercise_href(self.exercise)


def list_exercises_of_path(module: Module, path: ReadingPath | None) -> Sequence[Exercise]:
    """List the exercises of a path in its order; those of the module as one reads it, without a path."""
    return paths.order_exercises_by_path(path, exercises_in_reading_order(module))


def choose_next_exercise(
    module: Module,
    progress: Mapping[str, ExerciseProgress],
    path: ReadingPath | None,
    after: Exercise | None = None,
) -> NextExercise | None:
    """Return the exercise with which a reader goes on, `after` one that they have just solved if given.

    The first that they tried in vain, or else the first not solved that comes later on the way than `after`, or than
    all that they have solved, or else the first not solved at all. None for a way of which nothing is left.
    """
    way = list_exercises_of_path(module, path)
    left = [
        exercise
        for exercise in way
        if exercise is not after and not _progress_in_exercise(progress, exercise).succeeded
    ]
    begun = next((exercise for exercise in left if _progress_in_exercise(progress, exercise).attempts), None)
    if begun is not None:
        return NextExercise(begun, AGAIN, is_begun=True)
    if not left:
        return None
    solved = [place for place, exercise in enumerate(way) if _progress_in_exercise(progress, exercise).succeeded]
    place = way.index(after) if after in way else max(solved, default=-1)
    chosen = next((exercise for exercise in way[place + 1 :] if exercise in left), left[0])
    return NextExercise(chosen, _explain_choice(module, path, way, place, chosen), is_begun=False)


def _progress_in_exercise(progress: Mapping[str, ExerciseProgress], exercise: Exercise) -> ExerciseProgress:
    return progress.get(exercise.id, NOTHING_YET)


def _explain_choice(
    module: Module, path: ReadingPath | None, exercises: Sequence[Exercise], index: int, chosen: Exercise
) -> str:
    if path is not None:
        return ON_PATH.format(title=f"« {path.title} »")
    if index >= 0 and chosen.seance and chosen.seance == exercises[index].seance:
        label = next((lesson.label for lesson in module.lessons if lesson.slug == chosen.seance), "")
        if label:
            return NEXT_IN_LESSON.format(lesson=f"« {label} »")
    return FIRST_LEFT if exercises.index(chosen) < index else ""
