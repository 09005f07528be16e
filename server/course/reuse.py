"""Which earlier exercises one may build on: `reuses` of `exercise.toml`, and the files that come with a program.

A program imports their functions from `mes_fonctions`: the student's own, from the last attempt that got full marks,
or else the course's, which are never in its process (`server.sandbox.course_process`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from server.base.files import digest_files
from server.course import toml_file
from server.course.models import Course, CourseFault, Exercise, Problem
from server.course.toml_places import find_line_of_value
from server.sandbox.values import LibraryFile

#: The files of one student, by exercise ("l20/poses").
Own = Mapping[str, bytes]
NOTHING_OWN: Own = MappingProxyType({})


def exercise_ids_with_reused(curricula: Sequence[Path], exercise: str) -> frozenset[str]:
    """The names of an exercise and of those that it reuses, as their files say."""
    module, _, slug = exercise.partition("/")
    found, waiting = set[str](), [slug]
    while waiting:
        name = waiting.pop()
        paths = [room / module / "exercices" / name / "exercise.toml" for room in curricula]
        if name not in found:
            waiting += [exercise_id for path in paths if path.is_file() for exercise_id in _read_declared_reuses(path)]
        found.add(name)
    return frozenset(f"{module}/{name}" for name in found)


def _read_declared_reuses(path: Path) -> list[str]:
    """What an exercise says that it reuses; nothing where that cannot be read, which its own reading tells."""
    try:
        names = toml_file.parse_toml_values(toml_file.read_text(path), path).get("reuses", [])
    except CourseFault:
        return []
    return [name for name in names if isinstance(name, str)] if isinstance(names, list) else []


def add_transitive_reuses(folder: Path, exercises: Sequence[Exercise], problems: list[Problem]) -> list[Exercise]:
    """The exercises, each with all that it reuses, what these reuse in their turn included.

    Its version then changes with their solutions. Where what an exercise reuses cannot be, it is left out, and said.
    """
    named = {exercise.slug: exercise for exercise in exercises}
    made = []
    for exercise in exercises:
        reuses, faults = _transitive_reuses(exercise, named)
        problems += [_reuse_problem(folder, exercise, fault) for fault in faults]
        made.append(
            _set_reused_exercises(exercise, [named[slug] for slug in reuses])
            if reuses and not faults
            else _clear_reused_exercises(exercise)
        )
    return made


def _set_reused_exercises(exercise: Exercise, reused: Sequence[Exercise]) -> Exercise:
    head = "\0".join([exercise.version, *(f"{source.slug}\0{source.solution}" for source in reused)])
    return replace(exercise, reuses=tuple(source.slug for source in reused), version=digest_files([], head.encode()))


def _clear_reused_exercises(exercise: Exercise) -> Exercise:
    return replace(exercise, reuses=())


def _transitive_reuses(exercise: Exercise, named: Mapping[str, Exercise]) -> tuple[list[str], list[str]]:
    """Return the transitive closure of an exercise's reuses, nearest first, and its faults."""
    found: list[str] = []
    waiting = list(exercise.reuses)
    while waiting:
        slug = waiting.pop(0)
        if slug in found:
            continue
        if slug not in named or named[slug].kind != "code":
            return found, [f"« reuses » : aucun exercice de code du module ne se nomme « {slug} »"]
        if slug == exercise.slug:
            return found, ["« reuses » : cet exercice se réutiliserait lui-même"]
        found.append(slug)
        waiting += named[slug].reuses
    counts = Counter(function.name for slug in found for function in named[slug].functions)
    twice = sorted(name for name, count in counts.items() if count > 1)
    return found, [f"« reuses » : la fonction « {name} » viendrait de deux exercices" for name in twice]


def _reuse_problem(folder: Path, exercise: Exercise, message: str) -> Problem:
    path = folder / exercise.slug / "exercise.toml"
    return Problem(path, find_line_of_value(toml_file.read_text(path), ("reuses",)), message)


def build_importable_library(
    course: Course, exercise: str, own: Own = NOTHING_OWN, tested: Collection[str] = ()
) -> tuple[LibraryFile, ...]:
    """What the programs of an exercise may import: of each that it reuses one's own file, or else the course's.

    All files of the course go along, as they import from one another, offered or not (`offers_course_functions`).
    """
    return tuple(_library_files(course.exercises[exercise], course.importable_exercises(exercise), own, tested))


def offers_course_functions(exercise: Exercise, reused: Exercise, tested: Collection[str]) -> bool:
    """Whether programs of an exercise may have the course's functions of an earlier one called.

    Not those of `tested` exercises, which a test asks the author to write, nor any that the exercise itself asks for.
    """
    asked = {function.name for function in exercise.functions}
    return reused.id not in tested and asked.isdisjoint(function.name for function in reused.functions)


def _library_files(
    exercise: Exercise, reused_exercises: Iterable[Exercise], own: Own, tested: Collection[str]
) -> Iterator[LibraryFile]:
    for reused in reused_exercises:
        functions = tuple(function.name for function in reused.functions)
        file = own.get(reused.id)
        if file is not None:
            yield LibraryFile(reused.slug, functions, file)
        offered = file is None and offers_course_functions(exercise, reused, tested)
        yield LibraryFile(reused.slug, functions, reused.solution.encode(), sealed=True, offered=offered)
