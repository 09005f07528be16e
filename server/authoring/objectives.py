"""The faults of objectives: names that the course does not have, exercises and mistakes that no objective carries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from graders.core.code.grading import CodeGrader
from server.course import Course, Exercise, Module, Problem, toml_file
from server.course.models import Lesson
from server.course.objectives import Objective
from server.course.practice import practised_objectives
from server.course.toml_places import find_line_of_value

UNKNOWN_EXERCISE = "« exercises » : exercice inconnu « {name} »"
UNKNOWN_FUNCTION = "« exercises » : « {slug} » n’a pas de fonction « {function} »"
UNKNOWN_MISTAKE = "« mistakes » : « {slug} » n’a pas d’erreur « {mistake} »"
UNKNOWN_EXERCISE_OF_MISTAKE = "« mistakes » : exercice inconnu « {name} » (il faut « exercice/erreur »)"
SAME_ID = "« id » : un autre objectif se nomme déjà « {id} »"
NO_OBJECTIVE = "aucun objectif ne nomme l’exercice « {slug} » : ajoutez-le aux « exercises » d’un [[objective]]"
NO_OBJECTIVE_OF_FUNCTION = (
    "aucun objectif ne porte les erreurs de « {slug} » dans « {function} » : ajoutez « {slug}:{function} » aux "
    "« exercises » d’un [[objective]]"
)
NO_OBJECTIVE_OF_MISTAKE = (
    "aucun objectif ne porte l’erreur « {mistake} » de « {slug} » : ajoutez « {slug}/{mistake} » aux « mistakes » d’un "
    "[[objective]]"
)


@dataclass(frozen=True)
class ExerciseMistakes:
    """An exercise as objectives may name it: its functions, and those in which each of its misconceptions occurs."""

    functions: tuple[str, ...]
    mistakes: Mapping[str, frozenset[str]]


def find_objective_faults(course: Course) -> Iterator[Problem]:
    """Yield the faults of all modules that have objectives with exercises. Loads their graders."""
    for module in course.modules.values():
        if practised_objectives(module):
            yield from _find_module_faults(module)


def _find_module_faults(module: Module) -> Iterator[Problem]:
    exercises = {exercise.slug: read_exercise_mistakes(exercise) for exercise in module.exercises}
    ids: set[str] = set()
    for lesson in module.lessons:
        for index, objective in enumerate(lesson.skills):
            found = list(_find_objective_faults(objective, exercises))
            if objective.id in ids:
                found.append(("id", SAME_ID.format(id=objective.id)))
            ids.add(objective.id)
            for key, message in found:
                yield Problem(lesson.text.source.path, _front_matter_line_of_objective(lesson, index, key), message)
    objectives = practised_objectives(module)
    for slug, exercise in exercises.items():
        for message in _find_uncarried_parts(objectives, slug, exercise):
            yield Problem(module.folder / "exercices" / slug / "exercise.toml", None, message)


def _front_matter_line_of_objective(lesson: Lesson, index: int, key: str) -> int:
    text = toml_file.read_text(lesson.text.source.path).partition("\n+++")[0].removeprefix("+++\n")
    return find_line_of_value(text, ("objective", index, key)) + 1


def read_exercise_mistakes(exercise: Exercise) -> ExerciseMistakes:
    if exercise.answers is not None:
        return ExerciseMistakes((), dict.fromkeys(exercise.answers.catalogue, frozenset()))
    mistakes: dict[str, frozenset[str]] = {}
    if isinstance(exercise.grader, CodeGrader):
        for entry in exercise.grader.misconceptions:
            mistakes[entry.id] = mistakes.get(entry.id, frozenset()) | frozenset(entry.functions)
    return ExerciseMistakes(tuple(function.name for function in exercise.functions), mistakes)


def _find_objective_faults(
    objective: Objective, exercises: Mapping[str, ExerciseMistakes]
) -> Iterator[tuple[str, str]]:
    """Yield the key that holds each fault, and a message."""
    for slug, functions in objective.exercises.items():
        if slug not in exercises:
            yield "exercises", UNKNOWN_EXERCISE.format(name=slug)
            continue
        for function in sorted(functions - set(exercises[slug].functions)):
            yield "exercises", UNKNOWN_FUNCTION.format(slug=slug, function=function)
    for slug, mistakes in objective.mistakes.items():
        if slug not in exercises:
            yield "mistakes", UNKNOWN_EXERCISE_OF_MISTAKE.format(name=slug)
            continue
        for mistake in sorted(mistakes - exercises[slug].mistakes.keys()):
            yield "mistakes", UNKNOWN_MISTAKE.format(slug=slug, mistake=mistake)


def _find_uncarried_parts(objectives: Sequence[Objective], slug: str, exercise: ExerciseMistakes) -> Iterator[str]:
    """Yield a message for what no objective carries of an exercise: all of it, a function, or misconceptions."""
    if not any(slug in objective.exercises for objective in objectives):
        yield NO_OBJECTIVE.format(slug=slug)
        return
    silent: set[str] = set()
    for mistake, functions in exercise.mistakes.items():
        if any(objective.does_misconception_belong(slug, mistake, functions) for objective in objectives):
            continue
        if not functions:
            yield NO_OBJECTIVE_OF_MISTAKE.format(slug=slug, mistake=mistake)
        elif functions.isdisjoint(silent):
            silent |= functions
            yield NO_OBJECTIVE_OF_FUNCTION.format(slug=slug, function=min(functions))
