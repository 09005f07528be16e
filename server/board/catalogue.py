"""Look misconceptions up in the course's catalogue."""

from __future__ import annotations

from dataclasses import dataclass

from graders.core.code.diagnosis import combine_diagnoses
from graders.core.code.grading import CodeGrader
from graders.core.contract.verdict import Diagnosis
from graders.core.declared.declaration import DeclaredMistake
from graders.core.declared.grading import DeclaredGrader
from server.course import Course, Exercise


@dataclass(frozen=True)
class CataloguedMisconception:
    """A misconception; `functions` are those in which it occurs, empty where they are not known.

    `question` makes a student see it, and starts a discussion; empty for a misconception that has left the course.
    """

    diagnosis: Diagnosis
    functions: tuple[str, ...] = ()
    question: str = ""


def find_misconception(course: Course, exercise_id: str, misconception: str) -> CataloguedMisconception:
    """Return the entry of the catalogue, or one with the bare name where the course has none (any more)."""
    exercise = course.exercises.get(exercise_id)
    entry = None if exercise is None else _find_catalogue_entry(exercise, misconception)
    return entry or CataloguedMisconception(Diagnosis(misconception, misconception, ""))


def _find_catalogue_entry(exercise: Exercise, misconception: str) -> CataloguedMisconception | None:
    if exercise.answers is not None:
        mistake = exercise.answers.catalogue.get(misconception)
        return None if mistake is None else CataloguedMisconception(mistake.to_diagnosis, (), mistake.question)
    if isinstance(exercise.grader, DeclaredGrader):
        declared = exercise.grader.declaration.mistakes
        return next((_from_declared_mistake(each) for each in declared if each.id == misconception), None)
    if not isinstance(exercise.grader, CodeGrader):
        return None
    catalogue = exercise.grader.misconceptions
    entries = [entry for entry in catalogue if entry.id == misconception]
    functions = tuple(dict.fromkeys(function for entry in entries for function in entry.functions))
    question = next((entry.question for entry in entries), "")
    try:
        return CataloguedMisconception(combine_diagnoses([misconception], catalogue), functions, question)
    except KeyError:
        return None


def _from_declared_mistake(mistake: DeclaredMistake) -> CataloguedMisconception:
    diagnosis = Diagnosis(mistake.id, mistake.title, mistake.explanation)
    return CataloguedMisconception(diagnosis, (), mistake.question)
