"""Look misconceptions up in the course's catalogue."""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.code.diagnosis import combine_diagnoses
from graders.core.code.grading import CodeGrader
from graders.core.contract.verdict import Diagnosis
from server.course import Course, Exercise


@dataclass(frozen=True)
class CataloguedMisconception:
    """A misconception; `functions` are those in which it occurs, empty where they are not known."""

    diagnosis: Diagnosis
    functions: tuple[str, ...] = ()


def find_misconception(course: Course, exercise_id: str, misconception: str) -> CataloguedMisconception:
    """Return the entry of the catalogue, or one with the bare name where the course has none (any more)."""
    exercise = course.exercises.get(exercise_id)
    entry = None if exercise is None else _catalogue_entry(exercise, misconception)
    return entry or CataloguedMisconception(Diagnosis(misconception, misconception, ""))


def _catalogue_entry(exercise: Exercise, misconception: str) -> CataloguedMisconception | None:
    if exercise.answers is not None:
        mistake = exercise.answers.catalogue.get(misconception)
        return None if mistake is None else CataloguedMisconception(mistake.diagnosis)
    if not isinstance(exercise.grader, CodeGrader):
        return None
    catalogue = exercise.grader.misconceptions
    functions = [function for entry in catalogue if entry.id == misconception for function in entry.functions]
    try:
        return CataloguedMisconception(combine_diagnoses([misconception], catalogue), tuple(dict.fromkeys(functions)))
    except KeyError:
        return None
