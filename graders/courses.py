"""Courses outside this repository: where they are, and how their graders, numerics and texts are imported.

A course is a folder with `curriculum/`, and, where it needs them, `graders/` and `reference/`, as this repository has
them. `BALISE_COURSES` names such folders (separated as in PATH), an installed package announces its own under the entry
point `balise.courses`. Their rooms are added to the packages of the same names: `graders.l19.gain.grader` is imported
by that name wherever it stands, and so are `reference.kalman` and `curriculum.l19.figures._plan`.

A name belongs to one course. Where two have it, the second course is left out whole, and it is said.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

ENVIRONMENT_VARIABLE = "BALISE_COURSES"
ENTRY_POINT_GROUP = "balise.courses"
REPOSITORY = Path(__file__).resolve().parents[1]
CURRICULUM, GRADERS, REFERENCE = "curriculum", "graders", "reference"
ROOMS = (CURRICULUM, GRADERS, REFERENCE)
IGNORED_NAMES = {"README"}


@dataclass(frozen=True)
class CourseProblem:
    """An error in a course; the other parts still serve."""

    path: Path
    line: int
    message: str


@dataclass
class Courses:
    """The available courses, this repository's first, and the errors of rejected ones."""

    folders: list[Path] = field(default_factory=lambda: [REPOSITORY])
    problems: list[CourseProblem] = field(default_factory=list)

    def add(self, folder: Path) -> None:
        """Add a course once, or record the errors for which it is rejected."""
        try:
            folder = folder.resolve()
            if folder in self.folders:
                return
            faults = [*_faults(folder)] or [*self._clashes(folder)]
        except (OSError, RuntimeError) as error:  # a folder that is not ours to read, a link that leads to itself
            faults = [CourseProblem(folder, 1, f"ce dossier de cours ne se lit pas : {error}.")]
        self.problems += faults
        if not faults:
            self.folders.append(folder)

    def _clashes(self, folder: Path) -> Iterator[CourseProblem]:
        for room in ROOMS:
            for name, path in _names(folder / room).items():
                for other in self.folders:
                    taken = _names(other / room).get(name)
                    if taken is not None:
                        message = (
                            f"« {name} » existe déjà : {taken}. Ce cours est laissé de côté ; renommez l’un des deux."
                        )
                        yield CourseProblem(path, 1, message)


def _faults(folder: Path) -> Iterator[CourseProblem]:
    if not folder.is_dir():
        yield CourseProblem(folder, 1, "ce dossier de cours n’existe pas.")
    elif not (folder / CURRICULUM).is_dir():
        yield CourseProblem(folder, 1, "ce n’est pas un cours : il n’a pas de dossier « curriculum ».")
    for room in ROOMS:
        if (folder / room / "__init__.py").exists():
            message = f"un cours s’ajoute au paquet « {room} », qui a déjà ce fichier : supprimez-le."
            yield CourseProblem(folder / room / "__init__.py", 1, message)


def _names(room: Path) -> dict[str, Path]:
    """Return the importable entries of a course's room, by module name."""
    entries = room.iterdir() if room.is_dir() else ()
    paths = {path.stem: path for path in entries if path.is_dir() or path.suffix == ".py"}
    return {name: path for name, path in paths.items() if name not in IGNORED_NAMES and not _apart(name, path)}


def _apart(name: str, path: Path) -> bool:
    """Whether two courses may share an entry: hidden files, drafts, private folders without code."""
    if name.startswith("_") and not name.startswith("__"):
        return path.is_dir() and not any(path.glob("*.py"))
    return name.startswith((".", "__"))


def find_courses() -> Courses:
    """Return the courses of this process: those of the environment variable, then the installed ones."""
    courses = Courses()
    for name in filter(None, os.environ.get(ENVIRONMENT_VARIABLE, "").split(os.pathsep)):
        courses.add(Path(os.path.expanduser(name)))
    for value, folder in _installed():
        if folder is None:
            message = f"le point d’entrée « {ENTRY_POINT_GROUP} » nomme « {value} », qui ne s’importe pas."
            courses.problems.append(CourseProblem(Path(value), 1, message))
        else:
            courses.add(folder)
    return courses


def _installed() -> Iterator[tuple[str, Path | None]]:
    """Yield the value of each entry point with the folder of its package, which is not imported."""
    from importlib.metadata import entry_points

    for point in entry_points(group=ENTRY_POINT_GROUP):
        try:
            spec = importlib.util.find_spec(point.module)
        except Exception:  # of "a.b", a is run: whatever it raises, the others still serve
            spec = None
        folders = list(spec.submodule_search_locations or ()) if spec else []
        yield point.value, Path(folders[0]) if folders else None


COURSES = find_courses()


def add_course(folder: Path) -> None:
    """Add a course after import: the packages of its rooms may be loaded already."""
    COURSES.add(folder)
    for room in ROOMS:
        package = sys.modules.get(room)
        if package is not None:
            package.__path__ = [str(folder) for folder in room_folders(room)]


def room_folders(name: str) -> list[Path]:
    """Return the folders of one room ("graders"), one for each course."""
    return [folder / name for folder in COURSES.folders]


def module_folder(slug: str) -> Path:
    """Return the curriculum folder of a module; this repository's path where none exists."""
    folders = [room / slug for room in room_folders(CURRICULUM)]
    return next((folder for folder in folders if folder.is_dir()), folders[0])
