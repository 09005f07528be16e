"""The faults of families: unknown names, misconceptions that are filed nowhere, families without any."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

from graders.core.compare.slips import SLIPS
from server.authoring.objectives import read_exercise_mistakes
from server.course import Course, Exercise, Problem
from server.course.filing import FILE

UNFILED = (
    "l’erreur « {mistake} » n’a pas de famille : rangez-la dans [families] sous une famille du cours, ou dans [apart] "
    "sous la raison pour laquelle elle n’en a pas"
)
UNKNOWN_FAMILY = "« {family} » n’est pas une famille de curriculum/families.toml"
UNKNOWN_MISTAKE = "« {mistake} » n’est pas une erreur de « {slug} »"
UNKNOWN_SLIP = "« slips » de « {family} » : « {slip} » n’est pas une étourderie connue : {known}"
#: The reason of a mistake that no other exercise knows.
OWN = "propre à cet exercice"
SHARED = (
    "« {mistake} » est dite propre à cet exercice, et « {other} » a une erreur du même nom : donnez-leur une famille, "
    "ou une raison qui dise en quoi elles diffèrent"
)
EMPTY_FAMILY = "la famille « {family} » ne réunit rien : aucun exercice n’y range d’erreur"


def find_family_faults(course: Course) -> Iterator[Problem]:
    """Yield the faults of the courses that have a file of families. Loads the graders."""
    filed = {name for exercise in course.exercises.values() for name in exercise.filing.families.values()}
    exercises_by_mistake: dict[str, list[str]] = defaultdict(list)
    for exercise in course.exercises.values():
        for mistake in (*exercise.filing.families, *exercise.filing.apart):
            exercises_by_mistake[mistake].append(exercise.slug)
    for path in sorted({module.folder.parent / FILE for module in course.modules.values()}):
        if not path.is_file():
            continue
        for module in course.modules.values():
            if module.folder.parent == path.parent:
                for exercise in module.exercises:
                    yield from _find_exercise_faults(course, exercise)
                    yield from _find_shared_mistake_faults(exercise, exercises_by_mistake)
        for family in course.families.values():
            for slip in sorted(set(family.slips) - SLIPS.keys()):
                message = UNKNOWN_SLIP.format(family=family.id, slip=slip, known=", ".join(sorted(SLIPS)))
                yield Problem(path, None, message)
            if family.id not in filed and not family.slips:
                yield Problem(path, None, EMPTY_FAMILY.format(family=family.id))


def _find_exercise_faults(course: Course, exercise: Exercise) -> Iterator[Problem]:
    path = exercise.statement.source.path.with_name(FILE)
    mistakes, filing = read_exercise_mistakes(exercise).mistakes, exercise.filing
    for family in sorted(set(filing.families.values()) - course.families.keys()):
        yield Problem(path, None, UNKNOWN_FAMILY.format(family=family))
    filed = filing.families.keys() | filing.apart.keys()
    for mistake in sorted(filed - mistakes.keys()):
        yield Problem(path, None, UNKNOWN_MISTAKE.format(mistake=mistake, slug=exercise.slug))
    for mistake in sorted(mistakes.keys() - filed):
        yield Problem(path, None, UNFILED.format(mistake=mistake))


def _find_shared_mistake_faults(
    exercise: Exercise, exercises_by_mistake: Mapping[str, Sequence[str]]
) -> Iterator[Problem]:
    """Yield the mistakes that are told to be of this exercise alone, though another has one of the same name."""
    path = exercise.statement.source.path.with_name(FILE)
    for mistake, reason in exercise.filing.apart.items():
        others = [slug for slug in exercises_by_mistake[mistake] if slug != exercise.slug]
        if reason == OWN and others:
            yield Problem(path, None, SHARED.format(mistake=mistake, other=others[0]))
