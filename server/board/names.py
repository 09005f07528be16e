"""What a misconception is called, and what is said of it: the course's catalogue."""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.code.diagnosis import combined
from graders.core.code.grading import CodeGrader
from graders.core.contract.verdict import Diagnosis
from server.course import Course, Exercise


@dataclass(frozen=True)
class Named:
    """A misconception; `functions` are those in which it is made, none where that is not known."""

    diagnosis: Diagnosis
    functions: tuple[str, ...] = ()


def named(course: Course, exercise_id: str, misconception: str) -> Named:
    """Its name alone where the course says nothing of it (any more)."""
    exercise = course.exercises.get(exercise_id)
    found = None if exercise is None else _catalogued(exercise, misconception)
    return found or Named(Diagnosis(misconception, misconception, ""))


def _catalogued(exercise: Exercise, misconception: str) -> Named | None:
    if exercise.answers is not None:
        mistake = exercise.answers.catalogue.get(misconception)
        return None if mistake is None else Named(mistake.diagnosis)
    if not isinstance(exercise.grader, CodeGrader):
        return None
    catalogue = exercise.grader.misconceptions
    functions = [function for one in catalogue if one.id == misconception for function in one.functions]
    try:
        return Named(combined([misconception], catalogue), tuple(dict.fromkeys(functions)))
    except KeyError:
        return None
