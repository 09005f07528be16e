"""Reading of `families.toml`: that of a course names families, that of an exercise files its misconceptions in them.

They stand apart from the catalogues of mistakes, which decide of verdicts: filing one changes no exercise's version.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType

from server.course import toml_file
from server.course.families import NO_FILING, FamilyFiling, MisconceptionFamily
from server.course.models import CourseFault, Problem
from server.course.schemas import ExerciseFamiliesFile, FamiliesFile
from server.course.toml_places import find_line_of_value

FILE = "families.toml"
SAME_ID = "« id » : une autre famille se nomme déjà « {id} »"
FILED_TWICE = "l’erreur « {mistake} » est rangée deux fois : laissez-la à une seule place"


def read_families(curricula: Iterable[Path], problems: list[Problem]) -> Mapping[str, MisconceptionFamily]:
    """Read the families of all courses, by id; a file that is malformed is reported and left out."""
    families: dict[str, MisconceptionFamily] = {}
    for path in (curriculum / FILE for curriculum in curricula):
        try:
            entries = toml_file.read_toml(path, FamiliesFile).family if path.is_file() else ()
        except CourseFault as fault:
            problems.append(fault.problem)
            continue
        for index, entry in enumerate(entries):
            if entry.id in families:
                line = find_line_of_value(toml_file.read_text(path), ("family", index, "id"))
                problems.append(Problem(path, line, SAME_ID.format(id=entry.id)))
            else:
                families[entry.id] = MisconceptionFamily(entry.id, entry.title, entry.summary, tuple(entry.slips))
    return MappingProxyType(families)


def read_exercise_families(exercise_folder: Path) -> FamilyFiling:
    """Read how an exercise files its misconceptions. Raise CourseFault for a malformed file."""
    path = exercise_folder / FILE
    if not path.is_file():
        return NO_FILING
    file = toml_file.read_toml(path, ExerciseFamiliesFile)
    filed: set[str] = set()
    for mistake, _ in (*_name_and_group_pairs(file.families), *_name_and_group_pairs(file.apart)):
        if mistake in filed:
            raise CourseFault(Problem(path, None, FILED_TWICE.format(mistake=mistake)))
        filed.add(mistake)
    return FamilyFiling(
        MappingProxyType(dict(_name_and_group_pairs(file.families))),
        MappingProxyType(dict(_name_and_group_pairs(file.apart))),
    )


def _name_and_group_pairs(groups: Mapping[str, list[str]]) -> Iterator[tuple[str, str]]:
    """Yield each mistake with the name of its group."""
    return ((mistake, name) for name, mistakes in groups.items() for mistake in mistakes)
